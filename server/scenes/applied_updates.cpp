// What the server derives from a batch of updates.
#include "server/scenes/applied_updates.h"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>
#include <unordered_set>

#include "scenegraph/instances/scene_trees.h"
#include "server/scenes/update_log.h"

namespace sightline::server::scenes {
namespace {

using scenegraph::instances::Level;
using scenegraph::model::DeleteNode;
using scenegraph::model::Mesh;
using scenegraph::model::Node;
using scenegraph::model::NodeId;
using scenegraph::model::NodeRef;
using scenegraph::model::PatchVertices;
using scenegraph::model::PutNode;
using scenegraph::model::SetTransforms;
using scenegraph::revision::Snapshot;

/// A node, and its share of the copied blocks of the node map.
constexpr std::uint64_t kBytesPerNode = sizeof(Node) + 1024;
/// The sums over a group above a changed node, and their share of the copied blocks of their map.
constexpr std::uint64_t kBytesPerGroup = sizeof(scenegraph::hierarchy::NodeSummary) + 320;
/// A node in the newest revision: itself, its share of the maps of nodes and of summaries, its
/// entry in its parent's list.
constexpr std::uint64_t kBytesPerHeldNode = sizeof(Node) + 320;
/// An empty scene.
constexpr std::uint64_t kBytesPerScene = 4096;
/// A group or an instance in a scene-level tree.
constexpr std::uint64_t kBytesPerPlaced = 256;

class Resolver {
 public:
  explicit Resolver(const std::vector<NodeId>& put) : put_(put) {}

  void operator()(PutNode& put) {
    resolve(put.parent);
    if (put.node < 0) aliases_.emplace(put.node, put_[next_]);
    put.node = static_cast<NodeRef>(put_[next_++]);
    put.mesh.reset();
  }
  void operator()(SetTransforms& set) {
    for (NodeRef& ref : set.nodes) resolve(ref);
  }
  void operator()(DeleteNode& removal) { resolve(removal.node); }
  void operator()(PatchVertices& patch) {
    for (NodeRef& ref : patch.nodes) resolve(ref);
  }

 private:
  void resolve(NodeRef& ref) const {
    if (ref < 0) ref = static_cast<NodeRef>(aliases_.at(ref));
  }

  const std::vector<NodeId>& put_;
  std::size_t next_ = 0;
  std::unordered_map<NodeRef, NodeId> aliases_;
};

class ReplacedBytes {
 public:
  explicit ReplacedBytes(const Snapshot& before) : before_(before) {}

  void operator()(const PutNode& put) {
    if (const Node* node = before_.find(static_cast<NodeId>(put.node))) {
      add(*node);
      names_ += bytes_of_texts(*node);
    }
  }
  void operator()(const SetTransforms& set) {
    bytes_ += std::min(set.nodes.size(), before_.node_count()) * kBytesPerNode;
    for (const NodeRef ref : set.nodes) {
      if (const Node* node = before_.find(static_cast<NodeId>(ref))) add_above(*node);
    }
  }
  void operator()(const DeleteNode& removal) {
    std::vector<NodeId> below{static_cast<NodeId>(removal.node)};
    while (!below.empty()) {
      const Node* node = before_.find(below.back());
      below.pop_back();
      if (node == nullptr) continue;  // put by this batch
      add(*node);
      names_ += bytes_of_texts(*node);
      below.insert(below.end(), node->children.begin(), node->children.end());
    }
  }
  void operator()(const PatchVertices& patch) {
    for (const NodeRef ref : patch.nodes) add(ref);
  }

  Replaced replaced() const { return {bytes_ + mesh_bytes_, mesh_bytes_, names_}; }

 private:
  void add(NodeRef ref) {
    if (const Node* node = before_.find(static_cast<NodeId>(ref))) add(*node);
  }
  void add(const Node& node) {
    bytes_ += kBytesPerNode + scenegraph::model::bytes_of_labels(node.labels);
    add_above(node);
    // The blob store counts meshes that are not patched.
    if (!node.patched || !meshes_.insert(node.mesh.get()).second) return;
    mesh_bytes_ += node.mesh->view().vertices.size_bytes() + node.mesh->tree_bytes();
  }

  /// Counts each group once: chains are long.
  void add_above(const Node& node) {
    for (NodeId at = node.parent; at != 0 && above_.insert(at).second;
         at = before_.find(at)->parent)
      bytes_ += kBytesPerGroup;
  }

  const Snapshot& before_;
  std::unordered_set<NodeId> above_;
  std::uint64_t bytes_ = 0, mesh_bytes_ = 0, names_ = 0;
  std::unordered_set<const Mesh*> meshes_;
};

class Deformed {
 public:
  explicit Deformed(const Snapshot& before) : before_(before) {}

  void operator()(const PutNode& put) {
    if (put.mesh != nullptr) put_[put.node] = put.mesh.get();
  }
  void operator()(const PatchVertices& patch) {
    if (patch.nodes.empty() || patch.nodes == last_) return;
    last_ = patch.nodes;
    const Mesh* const mesh = mesh_of(patch.nodes.front());
    if (mesh == nullptr) return;
    bytes_ += mesh->bytes_deformed();
    if (!mesh->is_resident()) bytes_read_ += mesh->bytes();
  }
  void operator()(const SetTransforms&) {}
  void operator()(const DeleteNode&) {}

  std::uint64_t bytes() const { return bytes_; }
  std::uint64_t bytes_read() const { return bytes_read_; }

 private:
  const Mesh* mesh_of(NodeRef ref) const {
    const auto put = put_.find(ref);
    if (put != put_.end()) return put->second;
    const Node* node = ref > 0 ? before_.find(static_cast<NodeId>(ref)) : nullptr;
    return node == nullptr ? nullptr : node->mesh.get();
  }

  const Snapshot& before_;
  std::unordered_map<NodeRef, const Mesh*> put_;
  std::vector<NodeRef> last_;
  std::uint64_t bytes_ = 0, bytes_read_ = 0;
};

bool patches(const scenegraph::model::Update& update) {
  return std::holds_alternative<PatchVertices>(update);
}

bool puts(const scenegraph::model::Update& update) {
  return std::holds_alternative<PutNode>(update);
}

bool deletes(const scenegraph::model::Update& update) {
  return std::holds_alternative<DeleteNode>(update);
}

}  // namespace

Result<Needed> needed_by(const Snapshot& before,
                         const std::vector<scenegraph::model::Update>& updates) {
  Needed needed;
  if (std::ranges::any_of(updates, patches)) {
    Deformed deformed(before);
    for (const scenegraph::model::Update& update : updates) std::visit(deformed, update);
    needed.meshes = deformed.bytes();
    needed.read = deformed.bytes_read();
  }
  if (needed.meshes > kMaxDeformedBytes) {
    return Error{
        Code::kResourceExhausted,
        fmt::format("the meshes that are patched need {} bytes, the limit of a batch is {}",
                    needed.meshes, kMaxDeformedBytes),
        "TOO_MUCH_DEFORMED"};
  }
  const auto nodes = std::ranges::count_if(updates, puts);
  if (nodes > 0)
    needed.nodes = bytes_of_nodes(static_cast<std::uint64_t>(nodes)) + bytes_of_names(updates);
  // What only deletes must be possible where there is no room left.
  if (!std::ranges::all_of(updates, deletes)) needed.log = bytes_of(updates);
  return needed;
}

std::uint64_t bytes_of_nodes(std::uint64_t nodes) { return nodes * kBytesPerHeldNode; }

std::uint64_t bytes_of_replaced(std::uint64_t nodes) { return nodes * kBytesPerNode; }

std::uint64_t bytes_of_scene(std::uint64_t nodes, std::uint64_t names) {
  return kBytesPerScene + bytes_of_nodes(nodes) + names;
}

std::uint64_t bytes_of_names(const std::vector<scenegraph::model::Update>& updates) {
  std::uint64_t bytes = 0;
  for (const scenegraph::model::Update& update : updates) {
    if (const auto* put = std::get_if<PutNode>(&update)) bytes += bytes_of_texts(*put);
  }
  return bytes;
}

void resolve(std::vector<scenegraph::model::Update>& updates, const std::vector<NodeId>& put) {
  Resolver resolver(put);
  for (scenegraph::model::Update& update : updates) std::visit(resolver, update);
}

Replaced bytes_replaced(const Snapshot& before,
                        const std::vector<scenegraph::model::Update>& updates) {
  ReplacedBytes visitor(before);
  for (const scenegraph::model::Update& update : updates) std::visit(visitor, update);
  return visitor.replaced();
}

std::uint64_t bytes_of_replaced_trees(const Snapshot& before, const Snapshot& after) {
  const std::vector<Level>& now = after.shared_trees().levels;
  std::uint64_t bytes = 0;
  for (const Level& level : before.shared_trees().levels) {
    const bool is_kept =
        std::ranges::any_of(now, [&](const Level& other) { return other.tree == level.tree; });
    if (!is_kept) bytes += bytes_of(*level.tree);
  }
  return bytes;
}

std::uint64_t bytes_of(const scenegraph::instances::SceneTrees& trees) {
  std::uint64_t bytes = 0;
  for (const Level& level : trees.levels) bytes += bytes_of(*level.tree);
  return bytes;
}

std::uint64_t bytes_of(const scenegraph::instances::SceneTree& tree) {
  const scenegraph::instances::Instances* instances = tree.instances_so_far();
  if (instances == nullptr || !instances->begun()) return 0;
  return instances->opened_members() * kBytesPerPlaced + instances->tree_bytes();
}

}  // namespace sightline::server::scenes

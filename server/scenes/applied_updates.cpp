// What the server derives from a batch of updates.
#include "server/scenes/applied_updates.h"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>
#include <unordered_set>

#include "scenegraph/instances/scene_trees.h"

namespace sightline::server::scenes {
namespace {

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

  void operator()(const PutNode& put) { add(put.node); }
  void operator()(const SetTransforms& set) { bytes_ += set.nodes.size() * kBytesPerNode; }
  void operator()(const DeleteNode& removal) {
    std::vector<NodeId> below{static_cast<NodeId>(removal.node)};
    while (!below.empty()) {
      const Node* node = before_.find(below.back());
      below.pop_back();
      if (node == nullptr) continue;  // put by this batch
      add(*node);
      below.insert(below.end(), node->children.begin(), node->children.end());
    }
  }
  void operator()(const PatchVertices& patch) {
    for (const NodeRef ref : patch.nodes) add(ref);
  }

  std::uint64_t bytes() const { return bytes_; }

 private:
  void add(NodeRef ref) {
    if (const Node* node = before_.find(static_cast<NodeId>(ref))) add(*node);
  }
  void add(const Node& node) {
    bytes_ += kBytesPerNode;
    // The blob store counts meshes that are not patched.
    if (!node.patched || !meshes_.insert(node.mesh.get()).second) return;
    bytes_ += node.mesh->view().vertices.size_bytes() + node.mesh->tree().bytes();
  }

  const Snapshot& before_;
  std::uint64_t bytes_ = 0;
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
    if (const Mesh* mesh = mesh_of(patch.nodes.front()))
      bytes_ += mesh->view().vertices.size_bytes();
  }
  void operator()(const SetTransforms&) {}
  void operator()(const DeleteNode&) {}

  std::uint64_t bytes() const { return bytes_; }

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
  std::uint64_t bytes_ = 0;
};

bool patches(const scenegraph::model::Update& update) {
  return std::holds_alternative<PatchVertices>(update);
}

}  // namespace

Status check_deformed(const Snapshot& before,
                      const std::vector<scenegraph::model::Update>& updates) {
  if (std::ranges::none_of(updates, patches)) return {};
  Deformed deformed(before);
  for (const scenegraph::model::Update& update : updates) std::visit(deformed, update);
  if (deformed.bytes() <= kMaxDeformedBytes) return {};
  return Error{Code::kResourceExhausted,
               fmt::format("the meshes that are patched have {} bytes of vertices, the limit of a "
                           "batch is {}",
                           deformed.bytes(), kMaxDeformedBytes),
               "TOO_MUCH_DEFORMED"};
}

void resolve(std::vector<scenegraph::model::Update>& updates, const std::vector<NodeId>& put) {
  Resolver resolver(put);
  for (scenegraph::model::Update& update : updates) std::visit(resolver, update);
}

std::uint64_t bytes_replaced(const Snapshot& before,
                             const std::vector<scenegraph::model::Update>& updates) {
  ReplacedBytes replaced(before);
  for (const scenegraph::model::Update& update : updates) std::visit(replaced, update);
  return replaced.bytes() + bytes_of(*before.shared_trees().dynamic_tree);
}

std::uint64_t bytes_of(const scenegraph::instances::SceneTree& tree) {
  const scenegraph::instances::Instances* instances = tree.instances_so_far();
  if (instances == nullptr || !instances->begun()) return 0;
  return instances->opened_members() * kBytesPerPlaced + instances->tree().tree().bytes();
}

}  // namespace sightline::server::scenes

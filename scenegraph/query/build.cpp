// Builds the trees of meshes and of the scene.
#include "scenegraph/query/build.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "accel/kdtree/epoch.h"
#include "accel/mesh/mesh_tree.h"
#include "scenegraph/instances/flat_scene.h"
#include "scenegraph/query/cast_counters.h"
#include "scenegraph/query/first_error.h"
#include "scenegraph/query/selection.h"

namespace sightline::scenegraph::query {
namespace {

using accel::kdtree::BuildCounters;

Error cancelled_error() { return {Code::kCancelled, "cancelled while building", "CANCELLED"}; }

/// Returns the ids, ascending, each once. Errors: kNotFound.
Result<std::vector<model::NodeId>> known_ids(const revision::Snapshot& snapshot,
                                             std::span<const model::NodeId> ids, const char* role) {
  std::vector<model::NodeId> sorted(ids.begin(), ids.end());
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  if (const Status known = check_nodes(snapshot, sorted, role); !known) return known.error();
  return sorted;
}

bool holds(std::span<const model::NodeId> sorted, model::NodeId id) {
  return std::binary_search(sorted.begin(), sorted.end(), id);
}

/// Whether a node above this one is among `sorted`.
bool is_below(const revision::Snapshot& snapshot, model::NodeId id,
              std::span<const model::NodeId> sorted) {
  return any_upward(snapshot.hierarchy(), snapshot.find(id)->parent,
                    [&](model::NodeId above) { return holds(sorted, above); });
}

void add_totals(std::span<const model::Mesh* const> meshes, BuildProgress& progress) {
  for (const model::Mesh* mesh : meshes) progress.triangles_total += mesh->triangles();
  progress.meshes_total += meshes.size();
}

/// Keeps a mesh's tree by joining it, not by a pin: the mesh may begin a new tree meanwhile, and a
/// pin would keep the lists of all cells alive.
class HeldTree {
 public:
  explicit HeldTree(const model::Mesh& mesh) : tree_(join(mesh)) {}
  ~HeldTree() { tree_.leave(); }
  HeldTree(const HeldTree&) = delete;
  HeldTree& operator=(const HeldTree&) = delete;
  accel::mesh::MeshTree& operator*() const { return tree_.tree; }

 private:
  static model::Mesh::OwnedTree& join(const model::Mesh& mesh) {
    const accel::kdtree::EpochPin pin;
    model::Mesh::OwnedTree& tree = mesh.owned_tree();
    tree.join();
    return tree;
  }
  model::Mesh::OwnedTree& tree_;
};

void build_mesh(const model::Mesh& mesh, const std::atomic<bool>* cancelled,
                BuildProgress& progress, BuildCounters& total) {
  BuildCounters built;
  const HeldTree tree(mesh);
  (*tree).expand_all(built, cancelled);
  progress.add(built.cells_expanded, built.seconds);
  total += built;
  if (is_cancelled(cancelled)) return;
  progress.triangles_done += mesh.triangles();
  ++progress.meshes_done;
}

Result<BuildCounters> build_meshes(std::span<const model::Mesh* const> meshes,
                                   const std::atomic<bool>* cancelled, BuildProgress& progress) {
  FirstError error;
  const BuildCounters built = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, meshes.size(), 1), BuildCounters{},
      [&](const tbb::blocked_range<std::size_t>& range, BuildCounters total) {
        for (std::size_t i = range.begin();
             i != range.end() && !is_cancelled(cancelled) && !error.happened(); ++i)
          error.run([&] { build_mesh(*meshes[i], cancelled, progress, total); });
        return total;
      },
      [](BuildCounters a, const BuildCounters& b) { return a += b; });
  if (error.happened()) return error.status().error();
  return built;
}

BuildCounters build_tree(const instances::Instances& tree, const std::atomic<bool>* cancelled,
                         BuildProgress& progress) {
  BuildCounters built;
  if (is_cancelled(cancelled)) return built;
  tree.tree().expand_all(built, cancelled);
  progress.add(built.cells_expanded, built.seconds);
  return built;
}

BuildCounters build_dynamic_trees(const instances::OpenTrees& trees,
                                  const std::atomic<bool>* cancelled, BuildProgress& progress) {
  BuildCounters built;
  for (const instances::OpenTree& tree : trees.dynamic())
    built += build_tree(tree.instances, cancelled, progress);
  return built;
}

/// Leaves out the meshes that are flat in every instance; they are done.
void leave_flat_out(const instances::OpenTrees& trees, std::vector<const model::Mesh*>& meshes,
                    BuildProgress& progress) {
  const auto flat = trees.static_tree().flat();
  if (flat == nullptr) return;
  std::unordered_set<const model::Mesh*> entered;
  for (const accel::kdtree::Reference& ref : flat->boxes())
    entered.insert(trees.static_tree()[ref.id].mesh);
  for (const instances::OpenTree& tree : trees.dynamic()) {
    tree.instances.open_all();
    for (std::size_t i = 0; i < tree.instances.size(); ++i) entered.insert(tree.instances[i].mesh);
  }
  std::erase_if(meshes, [&](const model::Mesh* mesh) {
    if (!flat->has(mesh) || entered.contains(mesh)) return false;
    progress.triangles_done += mesh->triangles();
    ++progress.meshes_done;
    return true;
  });
}

/// Makes the static instances flat, or builds the tree that rays find them by.
BuildCounters build_static_tree(const instances::Instances& tree,
                                const std::atomic<bool>* cancelled, BuildProgress& progress) {
  BuildCounters built;
  if (is_cancelled(cancelled)) return built;
  tree.make_flat(built, cancelled);
  progress.add(built.cells_expanded, built.seconds);
  return tree.flat() != nullptr ? built : build_tree(tree, cancelled, progress);
}

/// Whether all trees are complete. A tree is not if there was no memory for some of its cells.
bool is_complete(std::span<const model::Mesh* const> meshes, const instances::OpenTrees& trees) {
  const accel::kdtree::EpochPin pin;
  const auto is_built = [](const instances::OpenTree& tree) {
    return tree.instances.tree().is_complete();
  };
  return (trees.static_tree().flat() != nullptr || is_built(trees.all().front())) &&
         std::all_of(trees.dynamic().begin(), trees.dynamic().end(), is_built) &&
         std::all_of(meshes.begin(), meshes.end(), [](const model::Mesh* mesh) {
           return mesh->is_resident() && mesh->tree().is_complete();
         });
}

}  // namespace

Result<TraceStats> build_all(const revision::Snapshot& snapshot, const std::atomic<bool>* cancelled,
                             BuildProgress* progress) {
  if (progress == nullptr && snapshot.is_complete()) return TraceStats{};
  BuildProgress unreported;
  BuildProgress& reported = progress == nullptr ? unreported : *progress;
  std::vector<const model::Mesh*> meshes = snapshot.meshes();
  add_totals(meshes, reported);
  const std::uint64_t dropped = model::Mesh::trees_dropped();
  const instances::OpenTrees trees = snapshot.trees();
  const auto build = [&]() -> Result<std::pair<BuildCounters, BuildCounters>> {
    BuildCounters built = build_static_tree(trees.static_tree(), cancelled, reported);
    leave_flat_out(trees, meshes, reported);
    const Result<BuildCounters> built_meshes = build_meshes(meshes, cancelled, reported);
    if (!built_meshes) return built_meshes.error();
    built += *built_meshes;
    const BuildCounters dynamic = build_dynamic_trees(trees, cancelled, reported);
    built += dynamic;
    return std::pair(built, dynamic);
  };
  const auto done = or_error(build);
  if (!done) return done.error();
  const auto& [built, dynamic] = *done;
  if (is_cancelled(cancelled)) return cancelled_error();
  snapshot.nodes().for_each([](model::NodeId, const std::shared_ptr<const model::Node>& node) {
    if (hierarchy::is_instance(*node)) node->entered->store(true, std::memory_order_relaxed);
  });
  if (is_complete(meshes, trees)) snapshot.set_complete(dropped);
  TraceStats stats;
  add(built, stats);
  stats.dynamic_touches = dynamic.touches + dynamic.touches_prepare;
  return stats;
}

Result<TraceStats> build_shard(const revision::Snapshot& snapshot, const Shard& shard,
                               const std::atomic<bool>* cancelled) {
  std::vector<const model::Node*> nodes;
  snapshot.nodes().for_each([&](model::NodeId id, const std::shared_ptr<const model::Node>& node) {
    if (hierarchy::is_instance(*node) && shard.has(id)) nodes.push_back(node.get());
  });
  BuildProgress progress;
  Status built = build_mesh_trees(nodes, progress, cancelled);
  if (built) built = build_scene_tree(snapshot, progress, cancelled);
  if (!built) return built.error();
  TraceStats stats;
  stats.cells_expanded = progress.cells_expanded;
  stats.build_seconds = static_cast<double>(progress.build_us) * 1e-6;
  return stats;
}

Result<std::vector<const model::Node*>> mesh_nodes_under(const revision::Snapshot& snapshot,
                                                         std::span<const model::NodeId> roots,
                                                         std::span<const model::NodeId> excluded) {
  const std::vector<model::NodeId> all(snapshot.roots().begin(), snapshot.roots().end());
  const auto from = known_ids(snapshot, roots.empty() ? all : roots, "root");
  if (!from) return from.error();
  const auto without = known_ids(snapshot, excluded, "excluded");
  if (!without) return without.error();
  std::vector<model::NodeId> stack;
  for (const model::NodeId root : *from) {
    if (!is_below(snapshot, root, *from) && !is_below(snapshot, root, *without))
      stack.push_back(root);
  }
  std::vector<const model::Node*> nodes;
  while (!stack.empty()) {
    const model::NodeId id = stack.back();
    stack.pop_back();
    if (holds(*without, id)) continue;
    const model::Node& node = *snapshot.find(id);
    stack.insert(stack.end(), node.children.begin(), node.children.end());
    if (node.mesh != nullptr && !node.mesh->bounds().empty()) nodes.push_back(&node);
  }
  return nodes;
}

std::vector<const model::Mesh*> meshes_of(std::span<const model::Node* const> nodes) {
  std::vector<const model::Mesh*> meshes;
  std::unordered_set<const model::Mesh*> seen;
  for (const model::Node* node : nodes) {
    if (seen.insert(node->mesh.get()).second) meshes.push_back(node->mesh.get());
  }
  return meshes;
}

std::uint64_t triangles_begun(std::span<const model::Mesh* const> meshes) {
  std::uint64_t triangles = 0;
  for (const model::Mesh* mesh : meshes) {
    if (!mesh->is_resident()) continue;
    const accel::kdtree::EpochPin pin;
    const accel::mesh::MeshTree& tree = mesh->tree();
    if (!tree.untouched() && !tree.is_complete()) triangles += tree.growth().references_built;
  }
  return triangles;
}

Status build_mesh_trees(std::span<const model::Node* const> nodes, BuildProgress& progress,
                        const std::atomic<bool>* cancelled) {
  const Status done = or_error([&] {
    const std::vector<const model::Mesh*> meshes = meshes_of(nodes);
    add_totals(meshes, progress);
    const auto built = build_meshes(meshes, cancelled, progress);
    return built ? Status() : Status(built.error());
  });
  if (!done) return done.error();
  if (is_cancelled(cancelled)) return cancelled_error();
  for (const model::Node* node : nodes) node->entered->store(true, std::memory_order_relaxed);
  return {};
}

Status build_scene_tree(const revision::Snapshot& snapshot, BuildProgress& progress,
                        const std::atomic<bool>* cancelled) {
  const instances::OpenTrees trees = snapshot.trees();
  const Status done = or_error([&] {
    build_tree(trees.static_tree(), cancelled, progress);
    build_dynamic_trees(trees, cancelled, progress);
    return Status();
  });
  if (!done) return done.error();
  return is_cancelled(cancelled) ? Status(cancelled_error()) : Status();
}

}  // namespace sightline::scenegraph::query

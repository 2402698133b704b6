// Building trees before rays come.
#include "scenegraph/query/prefetch.h"

#include <algorithm>
#include <bit>
#include <string>
#include <unordered_set>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "accel/kdtree/epoch.h"
#include "scenegraph/query/ray_blocks.h"

namespace sightline::scenegraph::query {
namespace {

/// Rays that are grown for at a time: after each lot the progress is told.
constexpr std::size_t kRaysPerLot = 4096;
/// Of a tree, from the leaves up, where progress is estimated.
constexpr int kLevelsNotLookedAt = 9;

Error cancelled_error() { return {Code::kCancelled, "cancelled while building", "CANCELLED"}; }

/// Ascending, each once. Errors: kNotFound.
Result<std::vector<model::NodeId>> known_ids(const revision::Snapshot& snapshot,
                                             std::span<const model::NodeId> ids, const char* role) {
  std::vector<model::NodeId> sorted(ids.begin(), ids.end());
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  for (const model::NodeId id : sorted) {
    if (snapshot.find(id) != nullptr) continue;
    return Error{Code::kNotFound,
                 std::string(role) + " node " + std::to_string(id) + " is not in revision " +
                     std::to_string(snapshot.revision()),
                 "NODE_NOT_FOUND"};
  }
  return sorted;
}

bool holds(std::span<const model::NodeId> sorted, model::NodeId id) {
  return std::binary_search(sorted.begin(), sorted.end(), id);
}

/// Whether one of those above the node is among `sorted`.
bool is_below(const revision::Snapshot& snapshot, model::NodeId id,
              std::span<const model::NodeId> sorted) {
  for (id = snapshot.find(id)->parent; id != 0; id = snapshot.find(id)->parent) {
    if (holds(sorted, id)) return true;
  }
  return false;
}

void announce(std::span<const model::Mesh* const> meshes, BuildProgress& progress) {
  for (const model::Mesh* mesh : meshes) progress.triangles_total += mesh->triangles();
  progress.meshes_total += meshes.size();
}

void add(const accel::kdtree::BuildCounters& built, PrefetchProgress& progress) {
  progress.cells_expanded += built.cells_expanded;
  progress.build_us += static_cast<std::uint64_t>(built.seconds * 1e6);
}

/// Sums the weights of the cells that are to be built, as far as they lie in the first `levels`
/// levels: what is further down is small.
std::uint64_t weight_unbuilt(const accel::kdtree::KdTree& tree, accel::kdtree::Slot slot,
                             int levels) {
  if (slot.is_unbuilt()) return slot.cell()->weight;
  if (!slot.is_binary() || levels == 0) return 0;
  const accel::kdtree::AtomicSlot* children = tree.children(slot);
  return weight_unbuilt(tree, accel::kdtree::load(children[0]), levels - 1) +
         weight_unbuilt(tree, accel::kdtree::load(children[1]), levels - 1);
}

/// About how many of its triangles lie in finished parts of its tree.
std::uint64_t triangles_built(const model::Mesh& mesh) {
  // Cells of up to some ten thousand triangles appear all at once: enough levels to meet those.
  const int levels =
      std::max(0, static_cast<int>(std::bit_width(mesh.triangles())) - kLevelsNotLookedAt);
  const accel::kdtree::EpochPin pin;
  const accel::kdtree::KdTree* tree = mesh.tree().kd();
  if (tree == nullptr) return mesh.tree().untouched() ? 0 : mesh.triangles();
  const std::uint64_t left = weight_unbuilt(*tree, accel::kdtree::load(tree->root()), levels);
  return mesh.triangles() - std::min(left, mesh.triangles());  // a triangle may be in several cells
}

}  // namespace

/// A mesh while its tree is built: under way, and then done unless it was cancelled.
class TreeInWork {
 public:
  TreeInWork(const model::Mesh& mesh, PrefetchProgress& progress)
      : mesh_(mesh), progress_(progress) {
    const std::lock_guard lock(progress_.mutex_);
    progress_.under_way_.push_back(&mesh_);
  }
  void end(bool done) {
    const std::lock_guard lock(progress_.mutex_);
    std::erase(progress_.under_way_, &mesh_);
    if (!done) return;
    progress_.trees.triangles_done += mesh_.triangles();
    ++progress_.trees.meshes_done;
  }

 private:
  const model::Mesh& mesh_;
  PrefetchProgress& progress_;
};

std::uint64_t PrefetchProgress::triangles_reached() {
  const std::lock_guard lock(mutex_);
  std::uint64_t reached = trees.triangles_done;
  for (const model::Mesh* mesh : under_way_) reached += triangles_built(*mesh);
  return told_ = std::max(told_, reached);
}

Result<std::vector<const model::Node*>> mesh_nodes_under(const revision::Snapshot& snapshot,
                                                         std::span<const model::NodeId> roots,
                                                         std::span<const model::NodeId> excluded) {
  const auto from = known_ids(snapshot, roots.empty() ? snapshot.roots() : roots, "root");
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

Status build_mesh_trees(std::span<const model::Node* const> nodes, PrefetchProgress& progress,
                        const std::atomic<bool>* cancelled) {
  const std::vector<const model::Mesh*> meshes = meshes_of(nodes);
  announce(meshes, progress.trees);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, meshes.size(), 1),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin();
                           i != range.end() && !is_cancelled(cancelled); ++i) {
                        accel::kdtree::BuildCounters built;
                        TreeInWork work(*meshes[i], progress);
                        meshes[i]->tree().expand_all(built, cancelled);
                        add(built, progress);
                        work.end(!is_cancelled(cancelled));
                      }
                    });
  if (is_cancelled(cancelled)) return cancelled_error();
  for (const model::Node* node : nodes) node->entered->store(true, std::memory_order_relaxed);
  return {};
}

Status build_scene_tree(const revision::Snapshot& snapshot, PrefetchProgress& progress,
                        const std::atomic<bool>* cancelled) {
  accel::kdtree::BuildCounters built;
  const instances::TwoTrees trees = snapshot.trees();
  for (const instances::Instances* half : {&trees.still, &trees.moving}) {
    if (!is_cancelled(cancelled)) half->tree().expand_all(built, cancelled);
  }
  add(built, progress);
  return is_cancelled(cancelled) ? Status(cancelled_error()) : Status();
}

Status grow_for_rays(const revision::Snapshot& snapshot, std::span<const accel::geometry::Ray> rays,
                     TraceOptions options, PrefetchProgress& progress) {
  options.surface = false;
  const bool counts = options.kind == QueryKind::kCount || options.kind == QueryKind::kAll;
  std::vector<accel::geometry::Hit> hits(counts ? 0 : std::min(rays.size(), kRaysPerLot));
  std::vector<RayTally> tallies(counts ? std::min(rays.size(), kRaysPerLot) : 0);
  while (!rays.empty()) {
    const auto lot = rays.first(std::min(rays.size(), kRaysPerLot));
    rays = rays.subspan(lot.size());
    const auto cast = counts
                          ? count_hits(snapshot, lot, std::span(tallies).first(lot.size()), options)
                          : trace(snapshot, lot, std::span(hits).first(lot.size()), options);
    if (!cast) return cast.error();
    progress.cells_expanded += cast->cells_expanded;
    progress.build_us += static_cast<std::uint64_t>(cast->build_seconds * 1e6);
    progress.rays_done += lot.size();
  }
  return {};
}

}  // namespace sightline::scenegraph::query

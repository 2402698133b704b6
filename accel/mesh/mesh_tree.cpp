// Queries of a mesh's tree, which build it where rays need it.
#include "accel/mesh/mesh_tree.h"

#include <algorithm>

#include "accel/kdtree/walk.h"
#include "accel/mesh/face_references.h"
#include "accel/mesh/leaf_test.h"
#include "accel/mesh/runs.h"

namespace sightline::accel::mesh {
namespace {

/// The visitor of a kd-tree: at leaves and at deferred cells.
struct KdVisit : LeafTest {
  lazy::LazyTree& lazy;
  kdtree::BuildCounters& built;

  kdtree::DeferredAction deferred(kdtree::AtomicSlot& slot, const kdtree::DeferredCell& cell) {
    if (query.on_deferred == OnDeferred::kExpand) {
      const lazy::ExpandResult expanded = lazy.expand(slot, query.when_pending, built);
      if (expanded == lazy::ExpandResult::kRetry) return kdtree::DeferredAction::kRetry;
      if (expanded == lazy::ExpandResult::kPending) {
        query.suspended = true;
        query.progress = lazy::LazyTree::progress(slot);
        return kdtree::DeferredAction::kStop;
      }
    }
    query.saw_deferred = true;
    if (query.on_deferred == OnDeferred::kSkip) return kdtree::DeferredAction::kDone;
    return search(cell) ? kdtree::DeferredAction::kStop : kdtree::DeferredAction::kDone;
  }

  bool search(const kdtree::DeferredCell& cell) {
    if (cell.has_list)
      return cell.list.any_part(
          [&](std::span<const kdtree::Reference> refs) { return search(refs); });
    return search_faces({0, mesh.faces.size()});
  }

  bool search(std::span<const kdtree::Reference> refs) {
    return std::any_of(refs.begin(), refs.end(), [&](const kdtree::Reference& ref) {
      if (!may_meet(ray, ref.bounds(), limit())) return false;
      if (!ref.openable()) return test(ref.id);
      return search_faces(faces_of_run(mesh, ref));
    });
  }
};

}  // namespace

MeshTree::Tree MeshTree::make(const geometry::MeshView& mesh, const geometry::MeshView* own,
                              const MeshStats& stats, const TreeBuilder& builder,
                              References references, std::shared_ptr<const void> alive) {
  if (builder.whole != nullptr) return Tree(builder.whole->make(mesh));
  const bool may_run = references == References::kRuns && builder.rule->takes_runs();
  return Tree(std::in_place_type<lazy::LazyTree>, padded(stats.bounds), stats.finite_triangles,
              builder.rule, source_of_faces(mesh, stats.bounds, may_run, std::move(alive)), own);
}

MeshTree::MeshTree(geometry::MeshView mesh, const MeshStats& stats, const TreeBuilder& builder,
                   References references, std::shared_ptr<const void> alive)
    : mesh_(mesh),
      bounds_(padded(stats.bounds)),
      finite_triangles_(stats.finite_triangles),
      tree_(make(mesh, &mesh_, stats, builder, references, std::move(alive))) {}

void MeshTree::query(MeshQuery& query, kdtree::WalkCounters& walked, kdtree::BuildCounters& built) {
  kdtree::TreeRay ray;
  const double tmax = std::min(query.tmax, query.best_t);
  if (!enter(query.ray, bounds_, query.tmin / query.ray.unit, tmax / query.ray.unit, ray)) return;
  const LeafTest test{mesh_, query, ray, walked};
  if (auto* lazy = std::get_if<lazy::LazyTree>(&tree_)) {
    KdVisit visit{test, *lazy, built};
    walk(lazy->tree(), ray, lazy->root(), walked, visit);
  } else {
    query_whole(*std::get<std::unique_ptr<WholeTree>>(tree_), test, built);
  }
}

void MeshTree::query_whole(WholeTree& tree, LeafTest test, kdtree::BuildCounters& built) {
  if (!tree.is_built() && test.query.on_deferred == OnDeferred::kExpand) tree.build(built);
  if (tree.is_built()) return tree.query(test);
  test.query.saw_deferred = true;
  if (test.query.on_deferred == OnDeferred::kScan) test.search_faces({0, mesh_.faces.size()});
}

void MeshTree::expand_all(kdtree::BuildCounters& built, const std::atomic<bool>* cancelled) {
  if (auto* lazy = std::get_if<lazy::LazyTree>(&tree_)) return lazy->expand_all(built, cancelled);
  WholeTree& whole = *std::get<std::unique_ptr<WholeTree>>(tree_);
  if (!whole.is_built() && (cancelled == nullptr || !cancelled->load())) whole.build(built);
}

const kdtree::KdTree* MeshTree::kd() const {
  const auto* lazy = std::get_if<lazy::LazyTree>(&tree_);
  return lazy != nullptr ? &lazy->tree() : nullptr;
}

const WholeTree* MeshTree::whole() const {
  const auto* whole = std::get_if<std::unique_ptr<WholeTree>>(&tree_);
  return whole != nullptr ? whole->get() : nullptr;
}

bool MeshTree::untouched() const {
  return kd() != nullptr ? kdtree::load(kd()->root()).is_deferred() : !whole()->is_built();
}

std::uint64_t MeshTree::bytes() const { return kd() != nullptr ? kd()->bytes() : whole()->bytes(); }

kdtree::TreeMetrics MeshTree::metrics() const {
  return kd() != nullptr ? measure(*kd()) : whole()->metrics();
}

kdtree::GrowthMetrics MeshTree::growth() const {
  if (kd() != nullptr) return measure_growth(*kd(), mesh_.faces.size());
  if (!whole()->is_built()) return {.cells_deferred = 1};
  return {.cells_built = whole()->cells(), .references_built = finite_triangles_};
}

}  // namespace sightline::accel::mesh

// Queries of a mesh's tree, which build it where rays need it.
#include "accel/mesh/mesh_tree.h"

#include <algorithm>
#include <bit>

#include "accel/mesh/face_references.h"
#include "accel/mesh/float_walk.h"
#include "accel/mesh/leaf_test.h"
#include "accel/mesh/packet_query.h"

namespace sightline::accel::mesh {

MeshTree::Tree MeshTree::make(const geometry::MeshView& mesh, const geometry::MeshView* own,
                              const MeshStats& stats, const TreeBuilder& builder,
                              References references, std::shared_ptr<const void> alive) {
  if (builder.whole != nullptr) return Tree(builder.whole->make(mesh));
  const bool may_run = references == References::kRuns && builder.rule->takes_runs();
  return Tree(std::in_place_type<lazy::LazyTree>, padded(stats.bounds), stats.finite_triangles,
              builder.rule, source_of_faces(mesh, stats.bounds, may_run, std::move(alive)), own,
              builder.memory);
}

MeshTree::MeshTree(geometry::MeshView mesh, const MeshStats& stats, const TreeBuilder& builder,
                   References references, std::shared_ptr<const void> alive)
    : mesh_{mesh.vertices, mesh.faces, stats.finite_triangles == mesh.faces.size()},
      bounds_(padded(stats.bounds)),
      finite_triangles_(stats.finite_triangles),
      tree_(make(mesh, &mesh_, stats, builder, references, std::move(alive))) {}

void MeshTree::query(MeshQuery& query, kdtree::WalkCounters& walked, kdtree::BuildCounters& built) {
  kdtree::TreeRay ray;
  const double tmax = std::min(query.tmax, query.best_t);
  if (!enter(query.ray, bounds_, query.tmin / query.ray.unit, tmax / query.ray.unit, ray)) return;
  LeafTest test{mesh_, query, ray, walked};
  if (auto* lazy = std::get_if<lazy::LazyTree>(&tree_)) {
    if (query.on_deferred == OnDeferred::kWait && lazy->has_paid_for_all()) {
      query.wait_at(*lazy, nullptr);
      return;
    }
    lazy->count_rays(1);
    std::uint32_t saw_deferred = 0;  // the query knows
    if (lazy->makes_blocks() &&
        query_in_floats({{query, saw_deferred, walked, built}, *lazy, mesh_}, query))
      return;
    walk_lazily(*lazy, ray, query, walked, built, test);
  } else {
    query_whole(*std::get<std::unique_ptr<WholeTree>>(tree_), test, built);
  }
}

void MeshTree::query(wide::Packet& packet, std::uint32_t lanes, const PacketQuery& query) {
  auto* tree = std::get_if<lazy::LazyTree>(&tree_);
  if (tree != nullptr && tree->makes_blocks()) {
    lanes = query_packet({query, *tree, mesh_}, packet, lanes);
  }
  ask_each(query, packet, lanes,
           [&](LaneQuery& alone) { this->query(alone.query, query.walked, query.built); });
}

wide::PencilLanes MeshTree::query_pencil(std::span<wide::Packet> packets,
                                         const wide::PencilLanes& lanes,
                                         kdtree::WalkCounters& walked) {
  auto* tree = std::get_if<lazy::LazyTree>(&tree_);
  if (tree == nullptr || !tree->makes_blocks()) return {};
  wide::WalkTotals totals;
  const wide::PencilLanes done =
      wide::walk_pencil(packets, *tree->frame(), tree->entry(), lanes, totals);
  walked.steps += totals.nodes;
  walked.tests += totals.triangles;
  return done;
}

void MeshTree::query_whole(WholeTree& tree, LeafTest test, kdtree::BuildCounters& built) {
  const OnDeferred on_deferred = test.query.on_deferred;
  const bool may_build = on_deferred == OnDeferred::kExpand || on_deferred == OnDeferred::kDemand;
  if (!tree.is_built() && may_build) tree.build(built);
  if (tree.is_built()) return tree.query(test);
  test.query.saw_deferred = true;
  if (on_deferred == OnDeferred::kScan) test.everything();
}

void MeshTree::expand_all(kdtree::BuildCounters& built, const std::atomic<bool>* cancelled) {
  if (auto* lazy = std::get_if<lazy::LazyTree>(&tree_)) return lazy->expand_all(built, cancelled);
  WholeTree& whole = *std::get<std::unique_ptr<WholeTree>>(tree_);
  if (!whole.is_built() && (cancelled == nullptr || !cancelled->load())) whole.build(built);
}

bool MeshTree::is_complete() const {
  if (const auto* lazy = std::get_if<lazy::LazyTree>(&tree_)) return lazy->is_complete();
  return std::get<std::unique_ptr<WholeTree>>(tree_)->is_built();
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

// Queries of a mesh's tree, which build it where rays need it.
#include "accel/mesh/mesh_tree.h"

#include <algorithm>
#include <bit>

#include "accel/mesh/face_references.h"
#include "accel/mesh/face_test.h"
#include "accel/mesh/point_tests.h"
#include "accel/wide/float_rays.h"

namespace sightline::accel::mesh {

MeshTree::Tree MeshTree::make(const geometry::MeshView& mesh, const geometry::MeshView* own,
                              const MeshStats& stats, const TreeBuilder& builder,
                              References references, std::shared_ptr<const void> alive) {
  if (builder.whole != nullptr) return Tree(builder.whole->make(mesh, stats));
  return Tree(
      std::in_place_type<lazy::LazyTree>, padded(stats.bounds), stats.finite_triangles,
      builder.rule,
      source_of_faces(mesh, stats.bounds, references == References::kRuns, std::move(alive)), own,
      builder.memory);
}

MeshTree::MeshTree(geometry::MeshView mesh, const MeshStats& stats, const TreeBuilder& builder,
                   References references, std::shared_ptr<const void> alive)
    : mesh_{mesh.vertices, mesh.faces, stats.finite_triangles == mesh.faces.size()},
      bounds_(padded(stats.bounds)),
      finite_triangles_(stats.finite_triangles),
      tree_(make(mesh, &mesh_, stats, builder, references, std::move(alive))) {}

void MeshTree::query(wide::Packet& packet, std::uint32_t lanes, lazy::CellQuery& cells,
                     kdtree::WalkCounters& walked, kdtree::BuildCounters& built) {
  if (auto* tree = std::get_if<lazy::LazyTree>(&tree_))
    return query_faces(*tree, mesh_, packet, lanes, cells, walked, built);
  if (packet.points != nullptr) return query_whole_for_points(packet, lanes, cells, walked);
  packet.live = 0;
  for (lanes = packet.left(lanes); lanes != 0; lanes = packet.left(lanes & (lanes - 1))) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
    FaceTest test(mesh_, bounds_, packet, lane, cells, walked);
    if (test.ray().meets())
      query_whole(*std::get<std::unique_ptr<WholeTree>>(tree_), test, cells, walked, built);
  }
}

/// Trees that are built whole answer rays alone: points test all faces.
void MeshTree::query_whole_for_points(wide::Packet& packet, std::uint32_t lanes,
                                      const lazy::CellQuery& cells, kdtree::WalkCounters& walked) {
  lanes = wide::prepare(packet, wide::frame_of(bounds_), lanes);
  PointTests(mesh_, packet, cells, walked).faces(0, mesh_.faces.size(), lanes);
}

void MeshTree::query_whole(WholeTree& tree, FaceTest& test, const lazy::CellQuery& cells,
                           kdtree::WalkCounters& walked, kdtree::BuildCounters& built) {
  if (!tree.is_built() && may_grow(cells.growth) && !cells.samples) tree.build(built);
  if (tree.is_built()) return tree.query(test, walked);
  test.packet().saw_deferred |= 1u << test.ray().lane();
  if (cells.growth == lazy::Growth::kNone) test.everything();
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

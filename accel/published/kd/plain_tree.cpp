// Builds once, then answers queries.
#include "accel/published/kd/plain_tree.h"

#include <chrono>
#include <memory>

#include <tbb/task_arena.h>

#include "accel/kdtree/reference_list.h"
#include "accel/mesh/face_boxes.h"
#include "accel/mesh/face_test.h"
#include "accel/published/kd/plain_growth.h"
#include "accel/published/kd/plain_measure.h"
#include "accel/published/kd/traverse.h"

namespace sightline::accel::published::kd {

PlainTree::PlainTree(const geometry::MeshView& mesh, const mesh::MeshStats& stats,
                     const PlainRule& rule)
    : mesh_(mesh), bounds_(padded(stats.bounds)), rule_(rule) {}

PlainCells PlainTree::grow(kdtree::BuildCounters& counters) const {
  const std::size_t faces = mesh_.faces.size();
  kdtree::ReferenceList list(faces);
  list.shrink(mesh::face_references(mesh_, 0, faces, list.all().data()));
  counters.touches_prepare += faces;
  return grow_plain(rule_, mesh_, list.all(), bounds_, counters);
}

void PlainTree::build(kdtree::BuildCounters& counters) {
  const std::lock_guard lock(building_);
  if (is_built()) return;
  const auto begun = std::chrono::steady_clock::now();
  std::unique_ptr<const PlainCells> cells;
  // The build is isolated: this thread must not start a task meanwhile that waits for this lock.
  tbb::this_task_arena::isolate(
      [&] { cells = std::make_unique<const PlainCells>(grow(counters)); });
  ++counters.cells_expanded;
  ++counters.trees_begun;
  counters.seconds +=
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  built_.store(cells.release(), std::memory_order_release);
}

void PlainTree::query(mesh::FaceTest& test, kdtree::WalkCounters& walked) const {
  kdtree::WalkCounters own;
  walk(*built(), test.ray().in_tree(), own, test);
  test.packet().work[test.ray().lane()] += static_cast<std::uint32_t>(own.steps);
  walked += own;
}

kdtree::TreeMetrics PlainTree::metrics() const {
  if (is_built()) return measure(*built(), bounds_);
  return {.deferred_cells = 1};
}

}  // namespace sightline::accel::published::kd

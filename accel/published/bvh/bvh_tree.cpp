// Builds once, then answers queries.
#include "accel/published/bvh/bvh_tree.h"

#include <chrono>

#include <tbb/task_arena.h>

#include "accel/mesh/face_test.h"
#include "accel/published/bvh/bvh_measure.h"
#include "accel/published/bvh/traverse.h"

namespace sightline::accel::published::bvh {

void BvhTree::build(kdtree::BuildCounters& counters) {
  const std::lock_guard lock(building_);
  if (is_built()) return;
  const auto begun = std::chrono::steady_clock::now();
  std::unique_ptr<const Bvh> bvh;
  // The build is isolated: this thread must not start a task meanwhile that waits for this lock.
  tbb::this_task_arena::isolate(
      [&] { bvh = std::make_unique<const Bvh>(builder_.build(mesh_, counters)); });
  ++counters.cells_expanded;
  counters.seconds +=
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  built_.store(bvh.release(), std::memory_order_release);
}

void BvhTree::query(mesh::FaceTest& test, kdtree::WalkCounters& walked) const {
  kdtree::WalkCounters own;
  walk(*built(), test.ray().in_tree(), own, test);
  test.packet().work[test.ray().lane()] += static_cast<std::uint32_t>(own.steps);
  walked += own;
}

kdtree::TreeMetrics BvhTree::metrics() const {
  if (is_built()) return measure(*built());
  return {.deferred_cells = 1};
}

}  // namespace sightline::accel::published::bvh

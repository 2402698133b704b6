// Builds once, then answers queries.
#include "accel/published/bvh/bvh_tree.h"

#include <chrono>

#include <tbb/task_arena.h>

#include "accel/mesh/leaf_test.h"
#include "accel/published/bvh/bvh_measure.h"
#include "accel/published/bvh/bvh_walk.h"

namespace sightline::accel::published::bvh {

void BvhTree::build(kdtree::BuildCounters& counters) {
  const std::lock_guard lock(building_);
  if (is_built()) return;
  const auto begun = std::chrono::steady_clock::now();
  std::unique_ptr<const Bvh> bvh;
  // Isolated: this thread must not start a task meanwhile that waits for this lock.
  tbb::this_task_arena::isolate(
      [&] { bvh = std::make_unique<const Bvh>(builder_.build(mesh_, counters)); });
  ++counters.cells_expanded;
  counters.seconds +=
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  built_.store(bvh.release(), std::memory_order_release);
}

void BvhTree::query(mesh::LeafTest& test) const { walk(*built(), test.ray, test.walked, test); }

kdtree::TreeMetrics BvhTree::metrics() const {
  if (is_built()) return measure(*built());
  return {.deferred_cells = 1};
}

}  // namespace sightline::accel::published::bvh

// Building once, by whoever comes first.
#include "accel/published/bvh/bvh_tree.h"

#include <chrono>

#include <tbb/task_arena.h>

namespace sightline::accel::published::bvh {

const Bvh& BvhTree::build(kdtree::BuildCounters& counters) {
  const std::lock_guard lock(building_);
  if (const Bvh* bvh = built()) return *bvh;
  const auto begun = std::chrono::steady_clock::now();
  std::unique_ptr<const Bvh> bvh;
  // Isolated: this thread must not take up a ray meanwhile that waits for this very lock.
  tbb::this_task_arena::isolate(
      [&] { bvh = std::make_unique<const Bvh>(builder_.build(mesh_, counters)); });
  ++counters.cells_expanded;
  counters.seconds +=
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  built_.store(bvh.get(), std::memory_order_release);
  return *bvh.release();
}

}  // namespace sightline::accel::published::bvh

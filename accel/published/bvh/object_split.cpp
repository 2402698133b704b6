// Sweeps over all splits of sorted lists.
#include "accel/published/bvh/object_split.h"

#include <algorithm>

#include <tbb/parallel_for.h>

#include "accel/grow/fork.h"
#include "accel/split/cost_model.h"

namespace sightline::accel::published::bvh {
namespace {

/// Both terms of the sum grow with their sides. Where one term alone is not below the best sum, no
/// further split is.
void sweep(std::span<const Fragment> list, std::size_t axis, std::vector<double>& areas,
           ObjectSplit& best) {
  const std::size_t n = list.size();
  if (areas.size() < n) areas.resize(n);
  LaneBox right;
  std::size_t from = n;
  while (from > 1) {
    right.grow(list[from - 1].lo, list[from - 1].hi);
    const double term = half_area(right.aabb()) * static_cast<double>(n - from + 1);
    if (!(term < best.sum)) break;
    areas[--from] = term;
  }
  LaneBox left;
  for (std::size_t i = 1; i < n; ++i) {
    left.grow(list[i - 1].lo, list[i - 1].hi);
    if (i < from) continue;
    const double term = half_area(left.aabb()) * static_cast<double>(i);
    if (!(term < best.sum)) break;
    const double sum = term + areas[i];
    if (sum < best.sum) best = {axis, i, sum};
  }
}

}  // namespace

ObjectSplit best_object_split(const CenterLists& lists, SweepAreas& areas,
                              kdtree::BuildCounters& counters) {
  const std::size_t n = lists.size();
  if (n < 2) return {};
  counters.touches += 6 * n;
  // The limit is slightly below the sum of the whole: a split whose sum is equal up to rounding
  // separates nothing.
  ObjectSplit whole;
  whole.sum = half_area(lists.box) * static_cast<double>(n) * (1 - 0x1p-40);
  if (n < grow::kForkFrom) {
    ObjectSplit best = whole;
    for (const std::size_t axis : {0u, 1u, 2u}) sweep(lists.along[axis], axis, areas[axis], best);
    return best.found() ? best : ObjectSplit{};
  }
  std::array<ObjectSplit, 3> found{whole, whole, whole};
  tbb::parallel_for(std::size_t{0}, std::size_t{3}, [&](std::size_t axis) {
    sweep(lists.along[axis], axis, areas[axis], found[axis]);
  });
  ObjectSplit best;
  for (const ObjectSplit& split : found) {
    if (split.found() && split.sum < best.sum) best = split;
  }
  return best;
}

ObjectSplit middle_split(const CenterLists& lists) {
  const auto axis = static_cast<std::size_t>(split::longest_axis(lists.box));
  const std::size_t left = lists.size() / 2;
  return {axis, left, half_area(lists.box) * static_cast<double>(lists.size())};
}

}  // namespace sightline::accel::published::bvh

// Runs over siblings, and runs over runs.
#include "scenegraph/instances/sibling_clusters.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace sightline::scenegraph::instances {
namespace {

using accel::geometry::Aabb;
using accel::kdtree::BoxRef;

/// Runs whose boxes have on average more than this share of the parent's surface divide nothing.
constexpr double kLargestShare = 0.25;

BoxRef run_over(std::span<const BoxRef> members, std::uint32_t number) {
  Aabb box;
  std::uint64_t weight = 0;
  for (const BoxRef& ref : members) {
    box.grow(ref.bounds());
    weight += ref.weight;
  }
  constexpr std::uint64_t kLargest = std::numeric_limits<std::uint32_t>::max();
  return {box.lo, accel::kdtree::kOpenable | kRun | number, box.hi,
          static_cast<std::uint32_t>(std::min(weight, kLargest))};
}

/// Empty where the runs would be too large.
std::vector<BoxRef> level_over(std::span<const BoxRef> refs, const Aabb& box, std::uint32_t first) {
  std::vector<BoxRef> runs;
  runs.reserve((refs.size() + kRunLength - 1) / kRunLength);
  double areas = 0;
  for (std::size_t i = 0; i < refs.size(); i += kRunLength) {
    runs.push_back(run_over(refs.subspan(i, std::min(kRunLength, refs.size() - i)), first++));
    areas += half_area(runs.back().bounds());
  }
  if (areas > static_cast<double>(runs.size()) * kLargestShare * half_area(box)) runs.clear();
  return runs;
}

/// Every third bit of ten.
std::uint32_t spread(std::uint32_t x) {
  x = (x | x << 16) & 0x030000ffu;
  x = (x | x << 8) & 0x0300f00fu;
  x = (x | x << 4) & 0x030c30c3u;
  return (x | x << 2) & 0x09249249u;
}

/// Along a curve on which what is near is mostly near in space (Morton 1966).
void sort_by_place(std::vector<BoxRef>& refs, const Aabb& box) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> order(refs.size());
  for (std::size_t i = 0; i < refs.size(); ++i) {
    std::uint32_t code = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const double lo = static_cast<double>(box.lo[a]), hi = static_cast<double>(box.hi[a]);
      const double middle =
          (static_cast<double>(refs[i].lo[a]) + static_cast<double>(refs[i].hi[a])) * 0.5;
      const double share = (middle - lo) / (hi - lo);
      code |= spread(share > 0 ? static_cast<std::uint32_t>(std::min(share, 1.0) * 1023) : 0) << a;
    }
    order[i] = {code, static_cast<std::uint32_t>(i)};
  }
  std::sort(order.begin(), order.end());
  std::vector<BoxRef> sorted;
  sorted.reserve(refs.size());
  for (const auto& [code, i] : order) sorted.push_back(refs[i]);
  refs = std::move(sorted);
}

}  // namespace

std::size_t max_runs(std::size_t siblings) {
  std::size_t runs = 0;
  while (siblings > kFewSiblings) {
    siblings = (siblings + kRunLength - 1) / kRunLength;
    runs += siblings;
  }
  return runs;
}

std::vector<std::span<const BoxRef>> SiblingRuns::members() const {
  std::vector<std::span<const BoxRef>> runs;
  for (std::size_t level = 0; level + 1 < levels.size(); ++level) {
    const std::span<const BoxRef> refs = levels[level];
    for (std::size_t i = 0; i < refs.size(); i += kRunLength)
      runs.push_back(refs.subspan(i, std::min(kRunLength, refs.size() - i)));
  }
  return runs;
}

SiblingRuns make_runs(std::vector<BoxRef> siblings, const Aabb& box, std::uint32_t first) {
  SiblingRuns made;
  made.levels.push_back(std::move(siblings));
  while (made.coarsest().size() > kFewSiblings) {
    std::vector<BoxRef> runs = level_over(made.coarsest(), box, first);
    if (runs.empty() && made.levels.size() == 1) {
      sort_by_place(made.levels[0], box);
      runs = level_over(made.coarsest(), box, first);
    }
    if (runs.empty()) break;
    first += static_cast<std::uint32_t>(runs.size());
    made.levels.push_back(std::move(runs));
  }
  return made;
}

}  // namespace sightline::scenegraph::instances

// The recursion over sorted lists, left before right.
#include "accel/published/bvh/list_growth.h"

#include <algorithm>
#include <array>

#include "accel/grow/fork.h"

namespace sightline::accel::published::bvh {
namespace {

ListHalves by_plane(const CenterLists& node, const PlaneSplit& plan, SplitScratch& scratch,
                    kdtree::BuildCounters& counters) {
  Fragment* const buffer = scratch.lists.top(3 * plan.right);
  scratch.lists.take(3 * plan.right);
  return divide_by_plane(node, plan, buffer, counters);
}

/// Upper end of the range of BvhLeafRule::leaf_size.
constexpr std::size_t kMostInLeaf = 64;

}  // namespace

BvhChild ListGrowth::grow(const CenterLists& node, int depth, SplitScratch& scratch,
                          kdtree::BuildCounters& counters) const {
  if (is_leaf_unasked(node.size(), leaf_)) return leaf(node);
  if (budget_ != nullptr && budget_->exceeded()) return {};
  const ObjectSplit object = search_.between(node, depth, scratch, counters);
  const PlaneSplit* const plane =
      budget_ != nullptr ? search_.by_plane(node, depth, object, scratch, counters) : nullptr;
  const double sum = plane != nullptr ? plane->sum() : object.sum;
  if (leaf_.keeps(node.size(), half_area(node.box), sum)) return leaf(node);
  if (plane != nullptr && !budget_->take(plane->added(node.size()))) return {};
  const FragmentStack::Mark mark = scratch.lists.mark();
  const ListHalves halves =
      plane != nullptr ? by_plane(node, *plane, scratch, counters)
                       : divide_by_centers(node, object.axis, object.left, scratch.lists, counters);
  const BvhChild grown = grow_children(halves, depth + 1, scratch, counters);
  scratch.lists.release(mark);
  return grown;
}

BvhChild ListGrowth::grow_children(const ListHalves& halves, int depth, SplitScratch& scratch,
                                   kdtree::BuildCounters& counters) const {
  BvhChild left, right;
  if (std::min(halves.left.size(), halves.right.size()) >= grow::kForkFrom) {
    kdtree::BuildCounters right_counters;
    grow::fork([&] { left = grow(halves.left, depth, scratch, counters); },
               [&] {
                 SplitScratch own;
                 right = grow(halves.right, depth, own, right_counters);
               });
    counters += right_counters;
  } else {
    left = grow(halves.left, depth, scratch, counters);
    right = grow(halves.right, depth, scratch, counters);
  }
  // After exceeding the budget there may be no capacity for further nodes.
  if (budget_ != nullptr && budget_->exceeded()) return {};
  return growth_.inner(left, right);
}

BvhChild ListGrowth::leaf(const CenterLists& node) const {
  std::array<kdtree::Reference, kMostInLeaf> refs;
  std::size_t n = 0;
  for (const Fragment& f : node.along[0]) {
    const geometry::Aabb box = f.bounds();
    refs[n++] = {box.lo, f.id(), box.hi, 1};
  }
  const auto end = refs.begin() + static_cast<std::ptrdiff_t>(n);
  std::sort(refs.begin(), end,
            [](const kdtree::Reference& a, const kdtree::Reference& b) { return a.id < b.id; });
  return growth_.leaf({refs.data(), n}, node.box);
}

}  // namespace sightline::accel::published::bvh

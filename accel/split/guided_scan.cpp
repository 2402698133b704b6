// Bounds on the cost between planes, and the planes of the second pass that follow from them.
#include "accel/split/guided_scan.h"

#include <algorithm>
#include <array>
#include <limits>

#include "accel/split/child_scan.h"
#include "accel/split/scan_pass.h"

namespace sightline::accel::split {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostSegments = kdtree::kUniformPlanes - 1;

/// Cost of splits along one axis of a cell, in weight: expected tests in the children.
struct AxisCost {
  AxisCost(const geometry::Aabb& cell, std::size_t axis, double per_whole, double empty_bonus)
      : areas(cell, static_cast<int>(axis), per_whole),
        bonus(empty_bonus),
        lo(cell.lo[axis]),
        hi(cell.hi[axis]) {}

  double children(double x, double left, double right) const {
    return areas.children(x, left, right, bonus);
  }
  bool inside(float x) const { return x > lo && x < hi; }

  SplitAreas areas;
  double bonus;
  float lo, hi;
};

/// The cheapest split so far; of equal ones the first.
struct Best {
  kdtree::Plane plane;
  double children = kNever;

  void offer(std::size_t axis, float x, double cost) {
    if (!(cost < children)) return;
    plane = {static_cast<int>(axis), x};
    children = cost;
  }
};

/// Bounds on the cost of splits between the planes of the first pass, along one axis.
struct SegmentBounds {
  std::array<double, kMostSegments>
      least;                 ///< Lower bound: no split within the segment costs less.
  double estimate = kNever;  ///< Estimated cost of the best split in any segment.
};

double share(double a, double b, double t) { return a + (b - a) * t; }

/// Estimate = lower bound + this share of the distance to the cost with evenly rising counts.
/// Measured.
constexpr double kEstimateBlend = 0.75;

SegmentBounds bound_segments(const AxisCost& cost, const UniformAxis& planes,
                             const kdtree::PlaneCounts<kdtree::kUniformPlanes>& n,
                             std::size_t samples, std::size_t axis, Best& best) {
  SegmentBounds bounds;
  for (std::size_t i = 0; i + 1 < samples; ++i) {
    const auto begin = static_cast<double>(planes[i]), end = static_cast<double>(planes[i + 1]);
    const double left = n.left[i], right = n.right[i + 1];
    const double all_left = n.left[i + 1], all_right = n.right[i];
    bounds.least[i] = std::min(cost.children(begin, left, right), cost.children(end, left, right));
    const double even =
        cost.children((begin + end) / 2, (left + all_left) / 2, (right + all_right) / 2);
    bounds.estimate = std::min(bounds.estimate, share(bounds.least[i], even, kEstimateBlend));
    if (i > 0 && cost.inside(planes[i])) {
      best.offer(axis, planes[i], cost.children(begin, left, all_right));
    }
  }
  return bounds;
}

/// Spreads planes over the segments that may cost less than `limit`: the same number in each, up to
/// rounding, evenly spaced. Adds `known`, which snapping may improve. Returns false if there is no
/// such segment.
bool spread_refined_planes(const SegmentBounds& bounds, const UniformAxis& planes,
                           std::size_t samples, double limit, std::optional<float> known,
                           WideAxis& placed) {
  std::array<std::size_t, kMostSegments> open;
  std::size_t count = 0;
  for (std::size_t i = 0; i + 1 < samples; ++i) {
    open[count] = i;
    count += bounds.least[i] < limit ? 1 : 0;
  }
  const std::size_t width = kScanWidth - (known ? 1 : 0);
  std::size_t n = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const auto begin = static_cast<double>(planes[open[k]]);
    const auto end = static_cast<double>(planes[open[k] + 1]);
    const std::size_t here = (k + 1) * width / count - n;
    for (std::size_t j = 1; j <= here; ++j) {
      const double at = static_cast<double>(j) / static_cast<double>(here + 1);
      placed[n++] = static_cast<float>(share(begin, end, at));
    }
  }
  if (known) placed[width] = *known;
  return count > 0;
}

/// Offers every plane, snapped to the next bound on the side with more weight; its counts hold up
/// to there.
void offer_snapped(const AxisCost& cost, std::size_t axis, const WideAxis& planes,
                   const kdtree::PlaneCounts<kScanWidth>& n, const PlaneNeighbours& near,
                   Best& best) {
  for (std::size_t i = 0; i < kScanWidth; ++i) {
    const float beside = n.left[i] > n.right[i] ? near.below[i] : near.above[i];
    const float x = cost.inside(beside) ? beside : planes[i];
    if (!cost.inside(x)) continue;
    best.offer(axis, x, cost.children(static_cast<double>(x), n.left[i], n.right[i]));
  }
}

/// One pass over some axes. A block of the list, small enough for the cache, is read for one axis
/// after the other.
PassResult refine_pass(std::span<const kdtree::Reference> refs, const std::array<bool, 3>& axes,
                       const std::array<WideAxis, 3>& planes) {
  constexpr std::size_t kBlock = 256;
  PassResult found;
  for (std::size_t i = 0; i < refs.size(); i += kBlock) {
    const auto block = refs.subspan(i, std::min(kBlock, refs.size() - i));
    for (std::size_t a = 0; a < 3; ++a) {
      if (axes[a])
        scan_wide_axis(block, static_cast<int>(a), planes[a], found.many[a], found.near[a]);
    }
  }
  return found;
}

std::array<kdtree::PlaneCounts<kdtree::kUniformPlanes>, 3> first_pass(
    const kdtree::CellRefs& list, const ChildPlanes& planes, kdtree::BuildCounters& counters) {
  if (list.first != nullptr && list.first->covers(list.size)) return list.first->axes;
  counters.touches += list.size;
  return run_pass(list,
                  [planes](std::span<const kdtree::Reference> refs) {
                    PassResult found;
                    scan_three_axes(refs, planes.at, found.few);
                    return found;
                  })
      .few;
}

}  // namespace

std::optional<kdtree::Split> choose_guided(const kdtree::CellRefs& list, const GuidedRule& rule,
                                           kdtree::BuildCounters& counters) {
  const ChildPlanes planes = child_planes(list.box, rule.uniform_samples);
  const std::array<kdtree::PlaneCounts<kdtree::kUniformPlanes>, 3> counts =
      first_pass(list, planes, counters);
  const std::size_t samples = rule.uniform_samples;
  const double per_whole = per_area(list.box);
  const auto along = [&](std::size_t a) {
    return AxisCost(list.box, a, per_whole, rule.cost.empty_bonus);
  };
  // A split whose children cost this much costs the same as a leaf.
  const double of_leaf = counts[0].left[samples - 1] - rule.cost.traverse / rule.cost.intersect;
  Best best;
  std::array<SegmentBounds, 3> bounds;
  std::size_t best_axis = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    bounds[a] = bound_segments(along(a), planes.at[a], counts[a], samples, a, best);
    if (bounds[a].estimate < bounds[best_axis].estimate) best_axis = a;
  }
  const double limit = std::min(best.children, of_leaf);
  const std::size_t begin = rule.refine_all_axes ? 0 : best_axis;
  const std::size_t end = rule.refine_all_axes ? 3 : best_axis + 1;
  std::array<bool, 3> placed{};
  std::array<WideAxis, 3> wide;
  for (std::size_t a = begin; a < end && !rule.once; ++a) {
    std::optional<float> known;
    if (best.children < kNever && best.plane.axis == static_cast<int>(a))
      known = best.plane.position;
    placed[a] = spread_refined_planes(bounds[a], planes.at[a], samples, limit, known, wide[a]);
  }
  if (placed[0] || placed[1] || placed[2]) {
    counters.touches += list.size;
    const PassResult found =
        run_pass(list, [placed, wide](std::span<const kdtree::Reference> refs) {
          return refine_pass(refs, placed, wide);
        });
    for (std::size_t a = begin; a < end; ++a)
      if (placed[a]) offer_snapped(along(a), a, wide[a], found.many[a], found.near[a], best);
  }
  if (!(best.children < of_leaf)) return std::nullopt;
  return kdtree::Split{best.plane};
}

}  // namespace sightline::accel::split

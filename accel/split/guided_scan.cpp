// Bounds on the cost between planes, and the planes that follow from them.
#include "accel/split/guided_scan.h"

#include <algorithm>
#include <array>
#include <limits>

#include "accel/split/child_scan.h"
#include "accel/split/scan_pass.h"

namespace sightline::accel::split {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostSegments = kdtree::kFirstPlanes - 1;

/// What cuts along one axis of a cell cost, in weight: tests to expect in the children.
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

  CutAreas areas;
  double bonus;
  float lo, hi;
};

/// The cheapest cut so far; the first of equal ones.
struct Best {
  kdtree::Plane plane;
  double children = kNever;

  void offer(std::size_t axis, float x, double cost) {
    if (!(cost < children)) return;
    plane = {static_cast<int>(axis), x};
    children = cost;
  }
};

/// What one axis may have between the planes of the first pass.
struct Outlook {
  std::array<double, kMostSegments> least;  ///< No cut within the segment costs less.
  double promise = kNever;                  ///< What the best of them may be hoped to cost.
};

double share(double a, double b, double t) { return a + (b - a) * t; }

/// From the least a segment can cost to what it costs if counts rise evenly; measured.
constexpr double kHope = 0.75;

Outlook look_at(const AxisCost& cost, const FirstAxis& planes,
                const kdtree::PlaneCounts<kdtree::kFirstPlanes>& n, std::size_t samples,
                std::size_t axis, Best& best) {
  Outlook outlook;
  for (std::size_t i = 0; i + 1 < samples; ++i) {
    const auto begin = static_cast<double>(planes[i]), end = static_cast<double>(planes[i + 1]);
    const double left = n.left[i], right = n.right[i + 1];
    const double all_left = n.left[i + 1], all_right = n.right[i];
    outlook.least[i] = std::min(cost.children(begin, left, right), cost.children(end, left, right));
    const double even =
        cost.children((begin + end) / 2, (left + all_left) / 2, (right + all_right) / 2);
    outlook.promise = std::min(outlook.promise, share(outlook.least[i], even, kHope));
    if (i > 0 && cost.inside(planes[i])) {
      best.offer(axis, planes[i], cost.children(begin, left, all_right));
    }
  }
  return outlook;
}

/// Planes over the segments that may cost less than `limit`, the same number in each but for
/// rounding, evenly within; and `known`, which may gain by moving. False if there is no such
/// segment.
bool place_where_it_pays(const Outlook& outlook, const FirstAxis& planes, std::size_t samples,
                         double limit, std::optional<float> known, WideAxis& placed) {
  std::array<std::size_t, kMostSegments> open;
  std::size_t count = 0;
  for (std::size_t i = 0; i + 1 < samples; ++i) {
    open[count] = i;
    count += outlook.least[i] < limit ? 1 : 0;
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

/// Every plane moves as far as its counts hold, toward the side with more on it.
void offer_moved(const AxisCost& cost, std::size_t axis, const WideAxis& planes,
                 const kdtree::PlaneCounts<kScanWidth>& n, const PlaneNeighbours& near,
                 Best& best) {
  for (std::size_t i = 0; i < kScanWidth; ++i) {
    const float beside = n.left[i] > n.right[i] ? near.below[i] : near.above[i];
    const float x = cost.inside(beside) ? beside : planes[i];
    if (!cost.inside(x)) continue;
    best.offer(axis, x, cost.children(static_cast<double>(x), n.left[i], n.right[i]));
  }
}

/// One pass over some axes: a stretch of the list that stays in the cache is read for one axis
/// after the other.
PassResult look_closely(std::span<const kdtree::BoxRef> refs, const std::array<bool, 3>& axes,
                        const std::array<WideAxis, 3>& planes) {
  constexpr std::size_t kStretch = 256;
  PassResult found;
  for (std::size_t i = 0; i < refs.size(); i += kStretch) {
    const auto stretch = refs.subspan(i, std::min(kStretch, refs.size() - i));
    for (std::size_t a = 0; a < 3; ++a) {
      if (axes[a])
        scan_wide_axis(stretch, static_cast<int>(a), planes[a], found.many[a], found.near[a]);
    }
  }
  return found;
}

std::array<kdtree::PlaneCounts<kdtree::kFirstPlanes>, 3> first_pass(
    const kdtree::CellRefs& list, const FirstPlanes& planes, kdtree::BuildCounters& counters) {
  if (list.first != nullptr && list.first->covers(list.size)) return list.first->axes;
  counters.touches += list.size;
  return run_pass(list,
                  [planes](std::span<const kdtree::BoxRef> refs) {
                    PassResult found;
                    scan_three_axes(refs, planes.at, found.few);
                    return found;
                  })
      .few;
}

}  // namespace

std::optional<kdtree::Cut> choose_guided(const kdtree::CellRefs& list, const GuidedRule& rule,
                                         kdtree::BuildCounters& counters) {
  const FirstPlanes planes = first_planes(list.box, rule.uniform_samples);
  const std::array<kdtree::PlaneCounts<kdtree::kFirstPlanes>, 3> counts =
      first_pass(list, planes, counters);
  const std::size_t samples = rule.uniform_samples;
  const double per_whole = per_area(list.box);
  const auto along = [&](std::size_t a) {
    return AxisCost(list.box, a, per_whole, rule.cost.empty_bonus);
  };
  // Children that cost as much make a cut as dear as a leaf.
  const double of_leaf = counts[0].left[samples - 1] - rule.cost.traverse / rule.cost.intersect;
  Best best;
  std::array<Outlook, 3> outlooks;
  std::size_t promising = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    outlooks[a] = look_at(along(a), planes.at[a], counts[a], samples, a, best);
    if (outlooks[a].promise < outlooks[promising].promise) promising = a;
  }
  const double limit = std::min(best.children, of_leaf);
  const std::size_t begin = rule.refine_all_axes ? 0 : promising;
  const std::size_t end = rule.refine_all_axes ? 3 : promising + 1;
  std::array<bool, 3> placed{};
  std::array<WideAxis, 3> wide;
  for (std::size_t a = begin; a < end && !rule.once; ++a) {
    std::optional<float> known;
    if (best.children < kNever && best.plane.axis == static_cast<int>(a))
      known = best.plane.position;
    placed[a] = place_where_it_pays(outlooks[a], planes.at[a], samples, limit, known, wide[a]);
  }
  if (placed[0] || placed[1] || placed[2]) {
    counters.touches += list.size;
    const PassResult found = run_pass(list, [placed, wide](std::span<const kdtree::BoxRef> refs) {
      return look_closely(refs, placed, wide);
    });
    for (std::size_t a = begin; a < end; ++a)
      if (placed[a]) offer_moved(along(a), a, wide[a], found.many[a], found.near[a], best);
  }
  if (!(best.children < of_leaf)) return std::nullopt;
  return kdtree::Cut{best.plane};
}

}  // namespace sightline::accel::split

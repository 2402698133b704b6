// Bounds on the cost between planes, and the planes that follow from them.
#include "accel/build/guided_scan.h"

#include <algorithm>
#include <array>
#include <limits>

#include "accel/build/first_scan.h"
#include "accel/build/list_pass.h"

namespace sightline::accel {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostSegments = kFirstPlanes - 1;

/// What cuts along one axis of a cell cost, in weight: tests to expect in the children.
struct AxisCost {
  AxisCost(const Aabb& cell, std::size_t axis, double empty_bonus)
      : areas(cell, static_cast<int>(axis)),
        bonus(empty_bonus),
        lo(cell.lo[axis]),
        hi(cell.hi[axis]) {}

  double children(double x, double left, double right) const {
    const double sum = (areas.left(x) * left + areas.right(x) * right) * areas.per_whole();
    return left == 0 || right == 0 ? sum * bonus : sum;
  }
  bool inside(float x) const { return x > lo && x < hi; }

  CutAreas areas;
  double bonus;
  float lo, hi;
};

/// The cheapest cut so far; the first of equal ones.
struct Best {
  Plane plane;
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

/// Half way from the least a segment can cost to what it costs if counts rise evenly.
constexpr double kHope = 0.5;

Outlook look_at(const AxisCost& cost, const FirstAxis& planes, const PlaneCounts<kFirstPlanes>& n,
                std::size_t samples, std::size_t axis, Best& best) {
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

/// kScanWidth planes over the segments that may cost less than `limit`, in proportion to by how
/// much; evenly within each. False if there is none.
bool place_where_it_pays(const Outlook& outlook, const FirstAxis& planes, std::size_t samples,
                         double limit, WideAxis& placed) {
  std::array<double, kMostSegments> gain{};
  double sum = 0;
  for (std::size_t i = 0; i + 1 < samples; ++i) {
    gain[i] = planes[i] < planes[i + 1] ? std::max(0.0, limit - outlook.least[i]) : 0.0;
    sum += gain[i];
  }
  if (!(sum > 0)) return false;
  std::size_t n = 0;
  double reached = 0.5;
  for (std::size_t i = 0; i + 1 < samples; ++i) {
    reached += gain[i] / sum * static_cast<double>(kScanWidth);
    const std::size_t end = std::min(static_cast<std::size_t>(reached), kScanWidth);
    const double step = 1 / static_cast<double>(end - n + 1);
    for (double at = step; n < end; at += step)
      placed[n++] = static_cast<float>(
          share(static_cast<double>(planes[i]), static_cast<double>(planes[i + 1]), at));
  }
  if (n == 0) return false;
  std::fill(placed.begin() + static_cast<std::ptrdiff_t>(n), placed.end(), placed[n - 1]);
  return true;
}

/// Every plane moves as far as its counts hold, toward the side with more on it.
void offer_moved(const AxisCost& cost, std::size_t axis, const WideAxis& planes,
                 const PlaneCounts<kScanWidth>& n, const PlaneNeighbours& near, Best& best) {
  for (std::size_t i = 0; i < kScanWidth; ++i) {
    const float beside = n.left[i] > n.right[i] ? near.below[i] : near.above[i];
    const float x = cost.inside(beside) ? beside : planes[i];
    if (!cost.inside(x)) continue;
    best.offer(axis, x, cost.children(static_cast<double>(x), n.left[i], n.right[i]));
  }
}

std::array<PlaneCounts<kFirstPlanes>, 3> first_pass(const CellRefs& list, const FirstPlanes& planes,
                                                    BuildCounters& counters) {
  if (list.first != nullptr && list.first->covers(list.size)) return list.first->axes;
  counters.touches += list.size;
  return run_pass(list,
                  [planes](std::span<const BoxRef> refs) {
                    PassResult found;
                    scan_three_axes(refs, planes.at, found.axes);
                    return found;
                  })
      .axes;
}

}  // namespace

std::optional<Cut> choose_guided(const CellRefs& list, const GuidedRule& rule,
                                 BuildCounters& counters) {
  const FirstPlanes planes = first_planes(list.box, rule.uniform_samples);
  const std::array<PlaneCounts<kFirstPlanes>, 3> counts = first_pass(list, planes, counters);
  const AxisCost costs[3] = {{list.box, 0, rule.cost.empty_bonus},
                             {list.box, 1, rule.cost.empty_bonus},
                             {list.box, 2, rule.cost.empty_bonus}};
  const std::size_t samples = rule.uniform_samples;
  const double weight = counts[0].left[samples - 1];
  // Children that cost as much make a cut as dear as a leaf.
  const double of_leaf = weight - rule.cost.traverse / rule.cost.intersect;
  Best best;
  std::array<Outlook, 3> outlooks;
  std::size_t axis = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    outlooks[a] = look_at(costs[a], planes.at[a], counts[a], samples, a, best);
    if (outlooks[a].promise < outlooks[axis].promise) axis = a;
  }
  WideAxis placed;
  const double limit = std::min(best.children, of_leaf);
  if (place_where_it_pays(outlooks[axis], planes.at[axis], samples, limit, placed)) {
    counters.touches += list.size;
    const PassResult found = run_pass(list, [axis, placed](std::span<const BoxRef> refs) {
      PassResult result;
      scan_wide_axis(refs, static_cast<int>(axis), placed, result.wide, result.near);
      return result;
    });
    offer_moved(costs[axis], axis, placed, found.wide, found.near, best);
  }
  if (!(best.children < of_leaf)) return std::nullopt;
  return Cut{best.plane};
}

}  // namespace sightline::accel

// Hunt's adaptive scan: the minimum of the interpolants, and our additions.
#include "accel/published/kd/hunt_scan.h"

#include <algorithm>
#include <array>
#include <limits>

#include "accel/published/kd/scan_samples.h"
#include "accel/split/exhaustive_split.h"
#include "accel/split/out_of_range.h"

namespace sightline::accel::published::kd {
namespace {

constexpr std::size_t index_of(int axis) { return static_cast<std::size_t>(axis); }

/// Offers the samples and, inside every segment, the vertex of the parabola that follows from
/// linear C_L, C_R, SA_L and SA_R. The parabola opens upward, because C_L and SA_L rise and C_R and
/// SA_R fall.
void offer_minima(const Samples& samples, const split::SplitAreas& areas,
                  const split::SahConstants& constants, int axis, const geometry::Aabb& cell,
                  split::BestSplit& best) {
  const auto offer = [&](double x, double left, double right) {
    const auto position = static_cast<float>(x);
    if (!(position > cell.lo[index_of(axis)] && position < cell.hi[index_of(axis)])) return;
    best.offer({axis, position}, split::split_cost(constants, areas, x, left, right));
  };
  for (std::size_t i = 0; i < samples.size; ++i) {
    const Sample& s = samples.at[i];
    offer(s.position, s.left, s.right);
    if (i + 1 == samples.size) break;
    const Sample& e = samples.at[i + 1];
    const double h = e.position - s.position;
    if (!(h > 0)) continue;
    const double left_slope = (e.left - s.left) / h, right_slope = (e.right - s.right) / h;
    const double curvature = areas.slope() * (left_slope - right_slope);
    const double slope = areas.slope() * (s.left - s.right) + areas.left(s.position) * left_slope +
                         areas.right(s.position) * right_slope;
    if (!(curvature > 0)) continue;
    const double u = -slope / (2 * curvature);
    if (u > 0 && u < h) offer(s.position + u, s.left + left_slope * u, s.right + right_slope * u);
  }
}

/// Offers the sampled splits. Returns the weight of the whole list, which is the weight below the
/// cell's upper face.
double offer_sampled(const HuntScan& builder, const kdtree::CellRefs& list, split::AxisRange range,
                     split::BestSplit& best, kdtree::BuildCounters& counters) {
  const std::array<Samples, 3> samples =
      sample_axes(list, range, builder.uniform_samples, builder.adaptive_samples, counters);
  for (int axis = range.begin; axis < range.end; ++axis) {
    offer_minima(samples[index_of(axis)], split::SplitAreas(list.box, axis), builder.cost, axis,
                 list.box, best);
  }
  const Samples& any = samples[index_of(range.begin)];
  return any.at[any.size - 1].left;
}

/// Replaces a sampled split, whose cost is an estimate, by the better of the two bounds next to it,
/// whose costs are exact.
void snap_to_bound(const kdtree::CellRefs& list, const split::SahConstants& constants,
                   split::BestSplit& best, kdtree::BuildCounters& counters) {
  const int axis = best.plane.axis;
  const std::size_t a = index_of(axis);
  const auto pass = [&](const split::WideAxis& planes) {
    counters.touches += list.size;
    return split::run_pass(list, [axis, planes](std::span<const kdtree::Reference> refs) {
      split::PassResult found;
      split::scan_wide_axis(refs, axis, planes, found.many[0], found.near[0]);
      return found;
    });
  };
  split::WideAxis planes;
  planes.fill(best.plane.position);
  const split::PlaneNeighbours near = pass(planes).near[0];
  std::size_t used = 0;
  for (const float x : {near.below[0], near.above[0]}) {
    if (x > list.box.lo[a] && x < list.box.hi[a]) planes[used++] = x;
  }
  if (used == 0) return;
  const kdtree::PlaneCounts<split::kScanWidth> counts = pass(planes).many[0];
  const split::SplitAreas areas(list.box, axis);
  best = {};
  for (std::size_t i = 0; i < used; ++i) {
    best.offer({axis, planes[i]},
               split::split_cost(constants, areas, static_cast<double>(planes[i]), counts.left[i],
                                 counts.right[i]));
  }
}

}  // namespace

std::optional<std::string> HuntScan::check() const {
  const auto most = static_cast<std::uint32_t>(kMostSamples);
  if (auto e = split::out_of_range("uniform_samples", uniform_samples, 2u, most)) return e;
  if (auto e = split::out_of_range("adaptive_samples", adaptive_samples, 0u, most)) return e;
  if (auto e = split::out_of_range("exact_below", exact_below, 0u, kMaxExact)) return e;
  if (auto e = split::out_of_range("cost_traverse", cost.traverse, 0.0, 1e6)) return e;
  if (auto e = split::out_of_range("cost_intersect", cost.intersect, 1e-6, 1e6)) return e;
  if (auto e = split::out_of_range("empty_bonus", cost.empty_bonus, 1e-6, 1.0)) return e;
  if (auto e = split::out_of_range("retry_above", retry_above, 1e-6,
                                   std::numeric_limits<double>::infinity()))
    return e;
  return std::nullopt;
}

std::optional<split::BoundRule> HuntScan::bound_rule(std::size_t references) const {
  if (references > exact_below) return std::nullopt;
  split::BoundRule rule{.cost = cost, .retry_above = retry_above};
  if (axes == ScanAxes::kOne) rule.all_axes_up_to = 0;
  if (axes == ScanAxes::kHybrid) rule.all_axes_up_to = hybrid_below;
  return rule;
}

std::optional<kdtree::Split> HuntScan::choose(const kdtree::CellRefs& list,
                                              kdtree::BuildCounters& counters) const {
  if (list.size == 0) return std::nullopt;
  if (const auto rule = bound_rule(list.size))
    return choose_bound(list.refs, list.box, *rule, counters);
  const bool all_axes =
      axes == ScanAxes::kAll || (axes == ScanAxes::kHybrid && list.size <= hybrid_below);
  const int longest = split::longest_axis(list.box);
  split::BestSplit best;
  double weight = 0;
  const auto offer = [&](split::AxisRange range) {
    weight = offer_sampled(*this, list, range, best, counters);
  };
  offer(all_axes ? split::AxisRange{} : split::AxisRange{longest, longest + 1});
  const bool may_retry = !all_axes && retry_above < std::numeric_limits<double>::infinity();
  if (may_retry && !(best.found && best.cost < retry_above * cost.intersect * weight)) {
    for (const int axis : {(longest + 1) % 3, (longest + 2) % 3}) offer({axis, axis + 1});
  }
  if (snap && best.found) snap_to_bound(list, cost, best, counters);
  if (!best.found || !(best.cost < cost.intersect * weight)) return std::nullopt;
  return kdtree::Split{best.plane};
}

}  // namespace sightline::accel::published::kd

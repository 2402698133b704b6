// Hunt's adaptive scan: samples, interpolants, minimum.
#include "accel/build/scan_builder.h"

#include <algorithm>
#include <array>
#include <limits>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "accel/build/scan_kernel.h"

namespace sightline::accel {
namespace {

/// Lists at least this long are scanned in slices of this many boxes, in parallel.
constexpr std::size_t kSlice = 32768;

/// What is known of C_L and C_R at one position.
struct Sample {
  double position = 0;
  double left = 0;
  double right = 0;
};

/// Samples of one axis by position, the cell's faces first and last.
struct Samples {
  std::array<Sample, kScanWidth> at;
  std::size_t size = 0;
};

constexpr std::size_t index_of(int axis) { return static_cast<std::size_t>(axis); }

int longest_axis(const Aabb& cell) {
  const Vec3f e = cell.hi - cell.lo;
  return e.x >= e.y && e.x >= e.z ? 0 : e.y >= e.z ? 1 : 2;
}

void add_counts(ScanAxis& to, const ScanAxis& from) {
  for (std::size_t i = 0; i < kScanWidth; ++i) {
    to.left[i] += from.left[i];
    to.right[i] += from.right[i];
  }
}

/// One pass: counts on all three axes, or on `axis` alone. Integer sums: the same however the list is sliced.
void count(std::span<const BoxRef> refs, bool all_axes, int axis, std::array<ScanAxis, 3>& axes) {
  const auto pass = [&](std::span<const BoxRef> slice, std::array<ScanAxis, 3>& counts) {
    if (all_axes) {
      scan_three_axes(slice, counts);
    } else {
      scan_one_axis(slice, axis, counts[index_of(axis)]);
    }
  };
  if (refs.size() < 2 * kSlice) return pass(refs, axes);
  const std::array<ScanAxis, 3> zero = axes;
  axes = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, refs.size(), kSlice), zero,
      [&](const tbb::blocked_range<std::size_t>& r, std::array<ScanAxis, 3> sum) {
        std::array<ScanAxis, 3> counts = zero;
        pass(refs.subspan(r.begin(), r.size()), counts);
        for (std::size_t a = 0; a < 3; ++a) add_counts(sum[a], counts[a]);
        return sum;
      },
      [](std::array<ScanAxis, 3> x, const std::array<ScanAxis, 3>& y) {
        for (std::size_t a = 0; a < 3; ++a) add_counts(x[a], y[a]);
        return x;
      });
}

/// Unused places repeat the last plane, so that a pass always takes a whole register.
void fill_unused(ScanAxis& planes, std::size_t used) {
  std::fill(planes.position.begin() + static_cast<std::ptrdiff_t>(used), planes.position.end(),
            used == 0 ? 0.0f : planes.position[used - 1]);
}

void place_uniform(ScanAxis& planes, float lo, float hi, std::uint32_t n) {
  for (std::uint32_t i = 0; i < n; ++i) {
    const double share = static_cast<double>(i) / (n - 1);
    planes.position[i] = static_cast<float>(static_cast<double>(lo) * (1 - share) + static_cast<double>(hi) * share);
  }
  fill_unused(planes, n);
}

Samples to_samples(const ScanAxis& planes, std::size_t n) {
  Samples samples;
  samples.size = n;
  for (std::size_t i = 0; i < n; ++i) {
    samples.at[i] = {static_cast<double>(planes.position[i]), static_cast<double>(planes.left[i]),
                     static_cast<double>(planes.right[i])};
  }
  return samples;
}

/// Section 5.2: n teeth evenly along the range of C_L - C_R; a segment gets as many new planes as teeth fall into it,
/// evenly spaced. Returns how many were placed (none where the function is constant).
std::size_t place_adaptive(const Samples& uniform, std::uint32_t n, ScanAxis& planes) {
  const auto rise = [](const Sample& s) { return s.left - s.right; };
  const double first = rise(uniform.at[0]);
  const double range = rise(uniform.at[uniform.size - 1]) - first;
  std::size_t placed = 0;
  if (range > 0) {
    // Tooth k stands at first + (k + 1/2) range / n.
    const auto teeth_below = [&](double value) {
      const double k = (value - first) / range * n + 0.5;
      return static_cast<std::size_t>(std::clamp(k, 0.0, static_cast<double>(n)));
    };
    for (std::size_t i = 0; i + 1 < uniform.size; ++i) {
      const Sample& s = uniform.at[i];
      const Sample& e = uniform.at[i + 1];
      const std::size_t teeth = teeth_below(rise(e)) - teeth_below(rise(s));
      for (std::size_t k = 1; k <= teeth; ++k) {
        const double share = static_cast<double>(k) / static_cast<double>(teeth + 1);
        planes.position[placed++] = static_cast<float>(s.position * (1 - share) + e.position * share);
      }
    }
  }
  fill_unused(planes, placed);
  return placed;
}

Samples merge(const Samples& a, const Samples& b) {
  Samples both;
  both.size = a.size + b.size;
  std::merge(a.at.begin(), a.at.begin() + static_cast<std::ptrdiff_t>(a.size), b.at.begin(),
             b.at.begin() + static_cast<std::ptrdiff_t>(b.size), both.at.begin(),
             [](const Sample& x, const Sample& y) { return x.position < y.position; });
  return both;
}

/// Offers the samples and, inside every segment, the vertex of the parabola that linear C_L, C_R, SA_L, SA_R make. The
/// parabola opens upward, because C_L and SA_L rise and C_R and SA_R fall.
void offer_minima(const Samples& samples, const CutAreas& areas, const SahConstants& constants, int axis, const Aabb& cell,
                  BestCut& best) {
  const auto offer = [&](double x, double left, double right) {
    const auto position = static_cast<float>(x);
    if (!(position > cell.lo[index_of(axis)] && position < cell.hi[index_of(axis)])) return;
    best.offer({axis, position}, cut_cost(constants, areas, x, left, right));
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

/// Section 6.2: every bound inside the cell is a candidate, counted by the same kernel, as many passes as it takes.
void offer_exact(std::span<const BoxRef> refs, int axis, const Aabb& cell, const SahConstants& constants,
                 BestCut& best, BuildCounters& counters) {
  const std::size_t a = index_of(axis);
  const float lo = cell.lo[a], hi = cell.hi[a];
  std::array<float, 2 * ScanBuilder::kMaxExact + kScanWidth> candidates;
  std::size_t n = 0;
  for (const BoxRef& ref : refs) {
    candidates[n] = ref.lo[a];
    n += static_cast<std::size_t>(ref.lo[a] > lo) & static_cast<std::size_t>(ref.lo[a] < hi);
    candidates[n] = ref.hi[a];
    n += static_cast<std::size_t>(ref.hi[a] > lo) & static_cast<std::size_t>(ref.hi[a] < hi);
  }
  if (n == 0) return;
  const std::size_t passes = (n + kScanWidth - 1) / kScanWidth;
  std::fill(candidates.begin() + static_cast<std::ptrdiff_t>(n),
            candidates.begin() + static_cast<std::ptrdiff_t>(passes * kScanWidth), candidates[0]);
  const CutAreas areas(cell, axis);
  const CutTerms terms{lo, hi, static_cast<float>(areas.ends() * areas.per_whole()),
                       static_cast<float>(areas.slope() * areas.per_whole()),
                       static_cast<float>(constants.empty_bonus)};
  const ExactCut cut = scan_exact(refs, axis, std::span(candidates).first(passes * kScanWidth), terms);
  counters.touches += passes * refs.size();
  best.offer({axis, cut.position}, constants.traverse + constants.intersect * static_cast<double>(cut.children));
}

/// The axes that are looked at together: all of them, or one.
struct AxisRange {
  int begin = 0, end = 3;
  bool all() const { return end - begin == 3; }
};

/// Returns the weight of the whole list: all of it lies below the cell's upper face.
double offer_sampled(const ScanBuilder& builder, std::span<const BoxRef> refs, const Aabb& cell, AxisRange range,
                     BestCut& best, BuildCounters& counters) {
  std::array<ScanAxis, 3> planes;
  for (int axis = range.begin; axis < range.end; ++axis) {
    const std::size_t a = index_of(axis);
    place_uniform(planes[a], cell.lo[a], cell.hi[a], builder.uniform_samples);
  }
  count(refs, range.all(), range.begin, planes);
  counters.touches += refs.size();
  std::array<Samples, 3> samples;
  std::array<std::size_t, 3> placed{};
  for (int axis = range.begin; axis < range.end; ++axis) {
    const std::size_t a = index_of(axis);
    samples[a] = to_samples(planes[a], builder.uniform_samples);
    placed[a] = place_adaptive(samples[a], builder.adaptive_samples, planes[a]);
    planes[a].left.fill(0);
    planes[a].right.fill(0);
  }
  if (placed[0] + placed[1] + placed[2] > 0) {
    count(refs, range.all(), range.begin, planes);
    counters.touches += refs.size();
  }
  for (int axis = range.begin; axis < range.end; ++axis) {
    const std::size_t a = index_of(axis);
    offer_minima(merge(samples[a], to_samples(planes[a], placed[a])), CutAreas(cell, axis), builder.cost, axis, cell, best);
  }
  const Samples& any = samples[index_of(range.begin)];
  return any.at[any.size - 1].left;
}

/// The bounds next to a position, each at or beyond it; infinite where there is none.
struct Neighbours {
  float below = -std::numeric_limits<float>::infinity();
  float above = std::numeric_limits<float>::infinity();
};

Neighbours nearest_bounds(std::span<const BoxRef> refs, std::size_t axis, float x) {
  Neighbours n;
  for (const BoxRef& ref : refs) {
    for (const float bound : {ref.lo[axis], ref.hi[axis]}) {
      n.below = bound <= x && bound > n.below ? bound : n.below;
      n.above = bound >= x && bound < n.above ? bound : n.above;
    }
  }
  return n;
}

/// Replaces a sampled cut, whose cost is an estimate, by the better of the bounds beside it, whose costs are true.
void snap_to_bound(std::span<const BoxRef> refs, const Aabb& cell, const SahConstants& constants, BestCut& best,
                   BuildCounters& counters) {
  const int axis = best.plane.axis;
  const std::size_t a = index_of(axis);
  const Neighbours n = nearest_bounds(refs, a, best.plane.position);
  ScanAxis planes;
  std::size_t used = 0;
  for (const float x : {n.below, n.above}) {
    if (x > cell.lo[a] && x < cell.hi[a]) planes.position[used++] = x;
  }
  if (used == 0) return;
  fill_unused(planes, used);
  scan_one_axis(refs, axis, planes);
  counters.touches += 2 * refs.size();
  const CutAreas areas(cell, axis);
  best = {};
  for (std::size_t i = 0; i < used; ++i) {
    best.offer({axis, planes.position[i]}, cut_cost(constants, areas, static_cast<double>(planes.position[i]),
                                                    planes.left[i], planes.right[i]));
  }
}

double total_weight(std::span<const BoxRef> refs) {
  std::uint64_t sum = 0;
  for (const BoxRef& ref : refs) sum += ref.weight;
  return static_cast<double>(sum);
}

}  // namespace

std::optional<std::string> ScanBuilder::check() const {
  const auto range = [](const char* name, auto value, auto lo, auto hi) -> std::optional<std::string> {
    if (value >= lo && value <= hi) return std::nullopt;
    return std::string(name) + " is " + std::to_string(value) + ", must lie in " + std::to_string(lo) + " to " +
           std::to_string(hi);
  };
  constexpr auto kHalf = static_cast<std::uint32_t>(kScanWidth / 2);
  if (auto e = range("uniform_samples", uniform_samples, 2u, kHalf)) return e;
  if (auto e = range("adaptive_samples", adaptive_samples, 0u, kHalf)) return e;
  if (auto e = range("exact_below", exact_below, 0u, kMaxExact)) return e;
  if (auto e = range("cost_traverse", cost.traverse, 0.0, 1e6)) return e;
  if (auto e = range("cost_intersect", cost.intersect, 1e-6, 1e6)) return e;
  if (auto e = range("empty_bonus", cost.empty_bonus, 1e-6, 1.0)) return e;
  if (auto e = range("retry_above", retry_above, 1e-6, std::numeric_limits<double>::infinity())) return e;
  return std::nullopt;
}

std::optional<Cut> ScanBuilder::choose(const CellRefs& list, BuildCounters& counters) const {
  const auto& [refs, cell, depth] = list;
  if (refs.empty()) return std::nullopt;
  const bool exact = refs.size() <= exact_below;
  const bool all_axes = axes == ScanAxes::kAll || (axes == ScanAxes::kHybrid && refs.size() <= hybrid_below);
  const int longest = longest_axis(cell);
  BestCut best;
  double weight = exact ? total_weight(refs) : 0;
  const auto offer = [&](AxisRange range) {
    if (!exact) {
      weight = offer_sampled(*this, refs, cell, range, best, counters);
      return;
    }
    for (int axis = range.begin; axis < range.end; ++axis) offer_exact(refs, axis, cell, cost, best, counters);
  };
  offer(all_axes ? AxisRange{} : AxisRange{longest, longest + 1});
  if (!all_axes && !(best.found && best.cost < retry_above * cost.intersect * weight)) {
    for (const int axis : {(longest + 1) % 3, (longest + 2) % 3}) {
      if (retry_above < std::numeric_limits<double>::infinity()) offer({axis, axis + 1});
    }
  }
  if (snap && !exact && best.found) snap_to_bound(refs, cell, cost, best, counters);
  if (!best.found || !(best.cost < cost.intersect * weight)) return std::nullopt;
  return Cut{best.plane};
}

}  // namespace sightline::accel

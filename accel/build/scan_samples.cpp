// Sample planes of one pass over a list, and where the next pass puts its own.
#include "accel/build/scan_samples.h"

#include <algorithm>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

namespace sightline::accel {
namespace {

void add_counts(ScanAxis& to, const ScanAxis& from) {
  for (std::size_t i = 0; i < kScanWidth; ++i) {
    to.left[i] += from.left[i];
    to.right[i] += from.right[i];
  }
}

}  // namespace

void count_planes(std::span<const BoxRef> refs, AxisRange range, std::array<ScanAxis, 3>& axes) {
  const auto pass = [&](std::span<const BoxRef> slice, std::array<ScanAxis, 3>& counts) {
    if (range.all()) {
      scan_three_axes(slice, counts);
    } else {
      scan_one_axis(slice, range.begin, counts[static_cast<std::size_t>(range.begin)]);
    }
  };
  if (refs.size() < 2 * kScanSlice) return pass(refs, axes);
  const std::array<ScanAxis, 3> zero = axes;
  axes = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, refs.size(), kScanSlice), zero,
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

void fill_unused(ScanAxis& planes, std::size_t used) {
  std::fill(planes.position.begin() + static_cast<std::ptrdiff_t>(used), planes.position.end(),
            used == 0 ? 0.0f : planes.position[used - 1]);
}

void place_uniform(ScanAxis& planes, float lo, float hi, std::uint32_t n) {
  for (std::uint32_t i = 0; i < n; ++i) {
    const double share = static_cast<double>(i) / (n - 1);
    planes.position[i] =
        static_cast<float>(static_cast<double>(lo) * (1 - share) + static_cast<double>(hi) * share);
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
        planes.position[placed++] =
            static_cast<float>(s.position * (1 - share) + e.position * share);
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

std::array<Samples, 3> sample_axes(std::span<const BoxRef> refs, const Aabb& cell, AxisRange range,
                                   std::uint32_t uniform, std::uint32_t adaptive,
                                   BuildCounters& counters) {
  std::array<ScanAxis, 3> planes;
  std::array<Samples, 3> samples;
  std::array<std::size_t, 3> placed{};
  const auto begin = static_cast<std::size_t>(range.begin),
             end = static_cast<std::size_t>(range.end);
  for (std::size_t a = begin; a < end; ++a)
    place_uniform(planes[a], cell.lo[a], cell.hi[a], uniform);
  count_planes(refs, range, planes);
  counters.touches += refs.size();
  for (std::size_t a = begin; a < end; ++a) {
    samples[a] = to_samples(planes[a], uniform);
    placed[a] = place_adaptive(samples[a], adaptive, planes[a]);
    planes[a].left.fill(0);
    planes[a].right.fill(0);
  }
  if (placed[0] + placed[1] + placed[2] == 0) return samples;
  count_planes(refs, range, planes);
  counters.touches += refs.size();
  for (std::size_t a = begin; a < end; ++a)
    samples[a] = merge(samples[a], to_samples(planes[a], placed[a]));
  return samples;
}

}  // namespace sightline::accel

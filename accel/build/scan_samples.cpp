// Sample planes of one pass over a list, and where the next pass puts its own.
#include "accel/build/scan_samples.h"

#include <algorithm>

namespace sightline::accel {
namespace {

using AxisPlanes = std::array<FirstAxis, 3>;
using AxisCounts = std::array<PlaneCounts<kFirstPlanes>, 3>;

/// One pass at these planes of the axes in range.
AxisCounts count_planes(const CellRefs& list, AxisRange range, const AxisPlanes& planes,
                        BuildCounters& counters) {
  counters.touches += list.size;
  return run_pass(list,
                  [range, planes](std::span<const BoxRef> refs) {
                    PassResult found;
                    const auto axis = static_cast<std::size_t>(range.begin);
                    if (range.all()) {
                      scan_three_axes(refs, planes, found.few);
                    } else {
                      scan_one_axis(refs, range.begin, planes[axis], found.few[axis]);
                    }
                    return found;
                  })
      .few;
}

}  // namespace

Samples to_samples(const FirstAxis& planes, const PlaneCounts<kFirstPlanes>& counts,
                   std::size_t n) {
  Samples samples;
  samples.size = n;
  for (std::size_t i = 0; i < n; ++i) {
    samples.at[i] = {static_cast<double>(planes[i]), static_cast<double>(counts.left[i]),
                     static_cast<double>(counts.right[i])};
  }
  return samples;
}

std::size_t place_adaptive(const Samples& uniform, std::uint32_t n, FirstAxis& planes) {
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
        planes[placed++] = static_cast<float>(s.position * (1 - share) + e.position * share);
      }
    }
  }
  std::fill(planes.begin() + static_cast<std::ptrdiff_t>(placed), planes.end(),
            placed == 0 ? 0.0f : planes[placed - 1]);
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

std::array<Samples, 3> sample_axes(const CellRefs& list, AxisRange range, std::uint32_t uniform,
                                   std::uint32_t adaptive, BuildCounters& counters) {
  AxisPlanes planes = first_planes(list.box, uniform).at;
  const bool known = list.first != nullptr && list.first->covers(list.size);
  AxisCounts counts = known ? list.first->axes : count_planes(list, range, planes, counters);
  std::array<Samples, 3> samples;
  std::array<std::size_t, 3> placed{};
  const auto begin = static_cast<std::size_t>(range.begin),
             end = static_cast<std::size_t>(range.end);
  for (std::size_t a = begin; a < end; ++a) {
    samples[a] = to_samples(planes[a], counts[a], uniform);
    placed[a] = place_adaptive(samples[a], adaptive, planes[a]);
  }
  if (placed[0] + placed[1] + placed[2] == 0) return samples;
  counts = count_planes(list, range, planes, counters);
  for (std::size_t a = begin; a < end; ++a)
    samples[a] = merge(samples[a], to_samples(planes[a], counts[a], placed[a]));
  return samples;
}

}  // namespace sightline::accel

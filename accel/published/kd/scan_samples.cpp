// Sample planes of one pass over a list, and the planes of the next pass.
#include "accel/published/kd/scan_samples.h"

#include <algorithm>

namespace sightline::accel::published::kd {
namespace {

using AxisPlanes = std::array<split::UniformAxis, 3>;
using AxisCounts = std::array<kdtree::PlaneCounts<kdtree::kUniformPlanes>, 3>;

/// Planes of one stage, on three axes; unused entries repeat the last.
struct StagePlanes {
  std::array<std::array<float, kMostSamples>, 3> at{};
  std::array<std::size_t, 3> used{};

  std::size_t passes() const {
    return (std::max({used[0], used[1], used[2]}) + kdtree::kUniformPlanes - 1) /
           kdtree::kUniformPlanes;
  }
  AxisPlanes of_pass(std::size_t pass) const {
    AxisPlanes planes;
    for (std::size_t a = 0; a < 3; ++a)
      std::copy_n(at[a].begin() + static_cast<std::ptrdiff_t>(pass * kdtree::kUniformPlanes),
                  kdtree::kUniformPlanes, planes[a].begin());
    return planes;
  }
};

/// Makes planes that are evenly spaced from face to face, both included.
StagePlanes uniform_planes(const geometry::Aabb& cell, split::AxisRange range, std::size_t n) {
  StagePlanes planes;
  for (int axis = range.begin; axis < range.end; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const auto lo = static_cast<double>(cell.lo[a]), hi = static_cast<double>(cell.hi[a]);
    planes.used[a] = n;
    for (std::size_t i = 0; i < kMostSamples; ++i) {
      const double share = static_cast<double>(std::min(i, n - 1)) / static_cast<double>(n - 1);
      planes.at[a][i] = static_cast<float>(lo * (1 - share) + hi * share);
    }
  }
  return planes;
}

/// Runs one pass at these planes, for the axes in range.
AxisCounts count_planes(const kdtree::CellRefs& list, split::AxisRange range,
                        const AxisPlanes& planes, kdtree::BuildCounters& counters) {
  counters.touches += list.size;
  return split::run_pass(list,
                         [range, planes](std::span<const kdtree::Reference> refs) {
                           split::PassResult found;
                           const auto axis = static_cast<std::size_t>(range.begin);
                           if (range.all()) {
                             split::scan_three_axes(refs, planes, found.few);
                           } else {
                             split::scan_one_axis(refs, range.begin, planes[axis], found.few[axis]);
                           }
                           return found;
                         })
      .few;
}

/// Runs all passes of a stage. `first` holds the counts of the first one, if known.
std::array<Samples, 3> sample_stage(const kdtree::CellRefs& list, split::AxisRange range,
                                    const StagePlanes& planes, const AxisCounts* first,
                                    kdtree::BuildCounters& counters) {
  std::array<Samples, 3> samples;
  for (std::size_t pass = 0; pass < planes.passes(); ++pass) {
    const AxisCounts counts = pass == 0 && first != nullptr
                                  ? *first
                                  : count_planes(list, range, planes.of_pass(pass), counters);
    for (std::size_t a = 0; a < 3; ++a) {
      Samples& s = samples[a];
      for (std::size_t i = 0; i < kdtree::kUniformPlanes && s.size < planes.used[a];
           ++i, ++s.size) {
        s.at[s.size] = {static_cast<double>(planes.at[a][s.size]),
                        static_cast<double>(counts[a].left[i]),
                        static_cast<double>(counts[a].right[i])};
      }
    }
  }
  return samples;
}

}  // namespace

std::size_t adaptive_planes(const Samples& uniform, std::uint32_t n, std::span<float> planes) {
  const auto rise = [](const Sample& s) { return s.left - s.right; };
  const double first = rise(uniform.at[0]);
  const double range = rise(uniform.at[uniform.size - 1]) - first;
  std::size_t placed = 0;
  if (range > 0) {
    // Tooth k is at first + (k + 1/2) range / n.
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

std::array<Samples, 3> sample_axes(const kdtree::CellRefs& list, split::AxisRange range,
                                   std::uint32_t uniform, std::uint32_t adaptive,
                                   kdtree::BuildCounters& counters) {
  const bool known =
      list.first != nullptr && uniform <= kdtree::kUniformPlanes && list.first->covers(list.size);
  std::array<Samples, 3> samples =
      sample_stage(list, range, uniform_planes(list.box, range, uniform),
                   known ? &list.first->axes : nullptr, counters);
  StagePlanes second;
  for (auto a = static_cast<std::size_t>(range.begin); a < static_cast<std::size_t>(range.end); ++a)
    second.used[a] = adaptive_planes(samples[a], adaptive, second.at[a]);
  if (second.passes() == 0) return samples;
  const std::array<Samples, 3> more = sample_stage(list, range, second, nullptr, counters);
  for (std::size_t a = 0; a < 3; ++a) samples[a] = merge(samples[a], more[a]);
  return samples;
}

}  // namespace sightline::accel::published::kd

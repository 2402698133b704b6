// Sampling C_L and C_R along an axis: uniform planes first, then planes where the difference rises.
// Source: Hunt, Mark, Stoll 2006, sections 5.2 and 6.1, Appendix A.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/split/child_scan.h"
#include "accel/split/scan_pass.h"

namespace sightline::accel::published::kd {

/// What is known of C_L and C_R at one position: the weight partly or wholly below, and above.
struct Sample {
  double position = 0;
  double left = 0;
  double right = 0;
};

/// Most samples an axis, uniform or adaptive.
inline constexpr std::size_t kMostSamples = 16;

/// Samples of one axis by position, the cell's faces first and last.
struct Samples {
  std::array<Sample, 2 * kMostSamples> at;
  std::size_t size = 0;
};

/// n teeth evenly along the range of C_L - C_R; a segment gets as many new planes as teeth fall
/// into it, evenly spaced (section 5.2, Figures 3 and 4). Returns how many were placed: n, or none
/// where the function is constant; unused planes repeat the last. n is at most planes.size().
std::size_t adaptive_planes(const Samples& uniform, std::uint32_t n, std::span<float> planes);

/// Both, by position; together at most 2 kMostSamples.
Samples merge(const Samples& a, const Samples& b);

/// The whole of section 5.2: uniform samples, then adaptive ones, over the axes in range; the
/// others stay empty. For every kUniformPlanes of either a pass is made, but for those uniform ones
/// of which it is known what it finds (CellRefs::first).
std::array<Samples, 3> sample_axes(const kdtree::CellRefs& list, split::AxisRange range,
                                   std::uint32_t uniform, std::uint32_t adaptive,
                                   kdtree::BuildCounters& counters);

/// The same for a list at hand.
inline std::array<Samples, 3> sample_axes(std::span<const kdtree::Reference> refs,
                                          const geometry::Aabb& cell, split::AxisRange range,
                                          std::uint32_t uniform, std::uint32_t adaptive,
                                          kdtree::BuildCounters& counters) {
  return sample_axes({refs, cell, {}}, range, uniform, adaptive, counters);
}

}  // namespace sightline::accel::published::kd

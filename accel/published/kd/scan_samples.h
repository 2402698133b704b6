// Samples C_L and C_R along an axis: at uniform planes first, then at planes where their difference
// rises. Source: Hunt, Mark, Stoll 2006, sections 5.2 and 6.1, Appendix A.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/split/child_scan.h"
#include "accel/split/scan_pass.h"

namespace sightline::accel::published::kd {

/// C_L and C_R at one position: the weight partly or wholly below it, and above it.
struct Sample {
  double position = 0;
  double left = 0;
  double right = 0;
};

/// Largest number of samples per axis, uniform or adaptive.
inline constexpr std::size_t kMostSamples = 16;

/// Samples of one axis in order of position; the first and the last are at the cell's faces.
struct Samples {
  std::array<Sample, 2 * kMostSamples> at;
  std::size_t size = 0;
};

/// Spreads n teeth evenly over the range of C_L - C_R; a segment gets as many new planes, evenly
/// spaced, as teeth fall into it (section 5.2, figures 3 and 4). Returns the number of planes: n,
/// or 0 if the function is constant. Unused entries repeat the last plane. n: at most
/// planes.size().
std::size_t adaptive_planes(const Samples& uniform, std::uint32_t n, std::span<float> planes);

/// Merges samples by position; together at most 2 kMostSamples.
Samples merge(const Samples& a, const Samples& b);

/// Does all of section 5.2: takes uniform samples, then adaptive ones, for the axes in range; the
/// others stay empty. Every kUniformPlanes planes take a pass, except for a first pass that is
/// already known (CellRefs::first).
std::array<Samples, 3> sample_axes(const kdtree::CellRefs& list, split::AxisRange range,
                                   std::uint32_t uniform, std::uint32_t adaptive,
                                   kdtree::BuildCounters& counters);

/// Samples a list in one piece.
inline std::array<Samples, 3> sample_axes(std::span<const kdtree::Reference> refs,
                                          const geometry::Aabb& cell, split::AxisRange range,
                                          std::uint32_t uniform, std::uint32_t adaptive,
                                          kdtree::BuildCounters& counters) {
  return sample_axes({refs, cell, {}}, range, uniform, adaptive, counters);
}

}  // namespace sightline::accel::published::kd

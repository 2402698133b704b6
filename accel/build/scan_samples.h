// Sampling C_L and C_R along an axis: uniform planes first, then planes where the difference rises.
// Source: Hunt, Mark, Stoll 2006, sections 5.2 and 6.1, Appendix A.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/build/scan_kernel.h"

namespace sightline::accel {

/// What is known of C_L and C_R at one position: the weight partly or wholly below, and above.
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

/// Lists of at least twice this many boxes are passed over in parallel slices of this size.
inline constexpr std::size_t kScanSlice = 32768;

/// One pass: adds the counts of the first kScanWidth / 2 planes of the axes in range, which must be
/// zero before. Long lists are scanned in parallel slices; sums of integers are the same however
/// the list is cut.
void count_planes(std::span<const BoxRef> refs, AxisRange range, std::array<ScanAxis, 3>& axes);

/// n planes evenly from lo to hi, both included (Appendix A.2: x_0 = a, x_{n-1} = b). n >= 2.
void place_uniform(ScanAxis& planes, float lo, float hi, std::uint32_t n);

/// n teeth evenly along the range of C_L - C_R; a segment gets as many new planes as teeth fall
/// into it, evenly spaced (section 5.2, Figures 3 and 4). Returns how many were placed: n, or none
/// where the function is constant.
std::size_t place_adaptive(const Samples& uniform, std::uint32_t n, ScanAxis& planes);

/// The first n planes of an axis with their counts.
Samples to_samples(const ScanAxis& planes, std::size_t n);

/// Both, by position.
Samples merge(const Samples& a, const Samples& b);

/// Repeats the last plane in the unused places, so that a pass always takes a whole register.
void fill_unused(ScanAxis& planes, std::size_t used);

/// The whole of section 5.2: two passes, uniform and adaptive, over the axes in range; the others
/// stay empty.
std::array<Samples, 3> sample_axes(std::span<const BoxRef> refs, const Aabb& cell, AxisRange range,
                                   std::uint32_t uniform, std::uint32_t adaptive,
                                   BuildCounters& counters);

}  // namespace sightline::accel

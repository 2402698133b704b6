// The inner loop of scan building: one pass over a list, counting what lies below and above a few
// sample planes. Source: Hunt, Mark, Stoll 2006, section 6.1. Differs: counts are sums of weights.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "accel/build/box_ref.h"

namespace sightline::accel {

/// Most planes of one axis, over both passes of sampling; each pass counts half of them.
inline constexpr std::size_t kScanWidth = 16;

/// Planes of one axis in any order (unused ones: repeat a used one), and what a pass counted.
struct ScanAxis {
  std::array<float, kScanWidth> position{};
  std::array<std::uint32_t, kScanWidth> left{};   ///< Weight with lo < position.
  std::array<std::uint32_t, kScanWidth> right{};  ///< Weight with hi > position.
};

/// The axes that one pass looks at: all three, or one.
struct AxisRange {
  int begin = 0, end = 3;
  bool all() const { return end - begin == 3; }
};

/// Counts the first kScanWidth / 2 planes of all three axes in one pass.
void scan_three_axes(std::span<const BoxRef> refs, std::array<ScanAxis, 3>& axes);

/// Counts the first kScanWidth / 2 planes of one axis in one pass.
void scan_one_axis(std::span<const BoxRef> refs, int axis, ScanAxis& planes);

/// What the kernels run on here, e.g. "AVX3".
std::string_view simd_target();

}  // namespace sightline::accel

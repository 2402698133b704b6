// The inner loops of scans: one pass over a list counts the weight below and above a few sample
// planes. Source: Hunt, Mark, Stoll 2006, section 6.1. Differs: counts are sums of weights.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>

#include "accel/kdtree/plane_counts.h"
#include "accel/kdtree/reference.h"

namespace sightline::accel::split {

/// Largest number of planes in a pass over one axis.
inline constexpr std::size_t kScanWidth = 2 * kdtree::kUniformPlanes;

/// The bounds next to each plane of one axis. A plane may move down to the next bound without a
/// change of the weight above it, and up to the next bound without a change of the weight below it.
/// Infinite where there is no bound.
struct PlaneNeighbours {
  std::array<float, kScanWidth> below;  ///< The greatest of lo < plane and hi <= plane.
  std::array<float, kScanWidth> above;  ///< The least of lo >= plane and hi > plane.

  PlaneNeighbours() {
    below.fill(-std::numeric_limits<float>::infinity());
    above.fill(std::numeric_limits<float>::infinity());
  }
  PlaneNeighbours& operator+=(const PlaneNeighbours& o) {
    for (std::size_t i = 0; i < kScanWidth; ++i) {
      below[i] = o.below[i] > below[i] ? o.below[i] : below[i];
      above[i] = o.above[i] < above[i] ? o.above[i] : above[i];
    }
    return *this;
  }
  bool operator==(const PlaneNeighbours&) const = default;
};

/// The axes of one pass: all three, or one.
struct AxisRange {
  int begin = 0, end = 3;
  bool all() const { return end - begin == 3; }
};

/// Planes in any order; unused entries repeat a used one.
using UniformAxis = std::array<float, kdtree::kUniformPlanes>;
using WideAxis = std::array<float, kScanWidth>;

/// Adds the counts of one pass over three axes.
void scan_three_axes(std::span<const kdtree::Reference> refs,
                     const std::array<UniformAxis, 3>& planes,
                     std::array<kdtree::PlaneCounts<kdtree::kUniformPlanes>, 3>& counts);

/// Adds the counts of one pass over one axis.
void scan_one_axis(std::span<const kdtree::Reference> refs, int axis, const UniformAxis& planes,
                   kdtree::PlaneCounts<kdtree::kUniformPlanes>& counts);

/// Adds the counts of one pass over one axis, and the bounds next to the planes.
void scan_wide_axis(std::span<const kdtree::Reference> refs, int axis, const WideAxis& planes,
                    kdtree::PlaneCounts<kScanWidth>& counts, PlaneNeighbours& near);

/// Name of the SIMD target that runs here, such as "AVX3".
std::string_view simd_target();

}  // namespace sightline::accel::split

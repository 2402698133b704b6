// The inner loops of scan building: one pass over a list, counting what lies below and above a few
// sample planes. Source: Hunt, Mark, Stoll 2006, section 6.1. Differs: counts are sums of weights.
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

/// Most planes of one axis that a pass looks at.
inline constexpr std::size_t kScanWidth = 2 * kdtree::kUniformPlanes;

/// How far the planes of one axis can move while what was counted there holds: down to the next
/// bound nothing more lies above a plane, up to the next nothing more lies below it. Infinite where
/// there is no bound.
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

/// The axes that one pass looks at: all three, or one.
struct AxisRange {
  int begin = 0, end = 3;
  bool all() const { return end - begin == 3; }
};

/// Planes in any order; unused places repeat a used one.
using UniformAxis = std::array<float, kdtree::kUniformPlanes>;
using WideAxis = std::array<float, kScanWidth>;

/// Adds what one pass over three axes counts.
void scan_three_axes(std::span<const kdtree::Reference> refs,
                     const std::array<UniformAxis, 3>& planes,
                     std::array<kdtree::PlaneCounts<kdtree::kUniformPlanes>, 3>& counts);

/// Adds what one pass over one axis counts.
void scan_one_axis(std::span<const kdtree::Reference> refs, int axis, const UniformAxis& planes,
                   kdtree::PlaneCounts<kdtree::kUniformPlanes>& counts);

/// Adds what one pass over one axis counts and which bounds it finds next to the planes.
void scan_wide_axis(std::span<const kdtree::Reference> refs, int axis, const WideAxis& planes,
                    kdtree::PlaneCounts<kScanWidth>& counts, PlaneNeighbours& near);

/// What the kernels run on here, e.g. "AVX3".
std::string_view simd_target();

}  // namespace sightline::accel::split

// Weights counted at a few planes by the first pass over a cell's list. They are kept with a
// deferred cell, so that the pass is not made again.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace sightline::accel::kdtree {

/// Largest number of planes per axis in a cell's first, uniform pass, and in any pass over three
/// axes.
inline constexpr std::size_t kUniformPlanes = 8;

/// Weights counted at the planes of one axis.
template <std::size_t kPlanes>
struct PlaneCounts {
  std::array<std::uint32_t, kPlanes> left{};   ///< Weight with lo < plane.
  std::array<std::uint32_t, kPlanes> right{};  ///< Weight with hi > plane.

  PlaneCounts& operator+=(const PlaneCounts& o) {
    for (std::size_t i = 0; i < kPlanes; ++i) {
      left[i] += o.left[i];
      right[i] += o.right[i];
    }
    return *this;
  }
  bool operator==(const PlaneCounts&) const = default;
};

/// Counts of the first pass over some of a cell's list. Counts of disjoint pieces add up.
struct ChildScan {
  std::size_t references = 0;  ///< Number of references counted.
  std::array<PlaneCounts<kUniformPlanes>, 3> axes;

  /// Whether the counts are of a whole list of `size` references. Code that changes a list after it
  /// was counted (opens, clips or removes references) must reset the counts.
  bool covers(std::size_t size) const { return size > 0 && references == size; }

  ChildScan& operator+=(const ChildScan& o) {
    references += o.references;
    for (std::size_t a = 0; a < 3; ++a) axes[a] += o.axes[a];
    return *this;
  }
  bool operator==(const ChildScan&) const = default;
};

}  // namespace sightline::accel::kdtree

// What the first pass over a cell's list counts: kept with a deferred cell, so that the pass need
// not be made again.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace sightline::accel::kdtree {

/// Most planes an axis of a cell's first, uniform pass, and of any pass over three axes.
inline constexpr std::size_t kUniformPlanes = 8;

/// What a pass counted at the planes of one axis.
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

/// What the first pass found in some of a cell's list. Adds up over disjoint pieces of it.
struct ChildScan {
  std::size_t references = 0;  ///< How many boxes were counted.
  std::array<PlaneCounts<kUniformPlanes>, 3> axes;

  /// Whether it stands for the whole of a list of that many boxes. Who changes a list after it was
  /// counted (boxes opened, clipped, left out) has to forget the counts.
  bool covers(std::size_t size) const { return size > 0 && references == size; }

  ChildScan& operator+=(const ChildScan& o) {
    references += o.references;
    for (std::size_t a = 0; a < 3; ++a) axes[a] += o.axes[a];
    return *this;
  }
  bool operator==(const ChildScan&) const = default;
};

}  // namespace sightline::accel::kdtree

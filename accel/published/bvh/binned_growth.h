// Grows a hierarchy by binned splits. Source: Wald 2007, "On fast Construction of SAH-based
// Bounding Volume Hierarchies".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "accel/kdtree/reference.h"
#include "accel/published/bvh/bvh_growth.h"
#include "accel/published/bvh/lanes.h"

namespace sightline::accel::published::bvh {

/// The bounds of a list's boxes, and of their centers.
struct ListSpan {
  LaneBox boxes, centers;

  void add(const kdtree::Reference& ref);
  void grow(const ListSpan& o) {
    boxes.grow(o.boxes);
    centers.grow(o.centers);
  }
};

/// A split between bins: bins up to `last_left` go left.
struct BinSplit {
  std::size_t axis = 0;
  std::uint32_t last_left = 0;
  /// Sum over both children of half area times references; infinite if none is found.
  double sum = std::numeric_limits<double>::infinity();
  bool found = false;
};

class CenterBins {
 public:
  static constexpr std::uint32_t kMaxBins = 256;

  /// Makes `bins` bins per axis over the bounds of centers, 2 to kMaxBins. An axis along which all
  /// centers coincide has no bins.
  CenterBins(const LaneBox& centers, std::uint32_t bins);

  void add(std::span<const kdtree::Reference> refs);
  CenterBins& operator+=(const CenterBins& o);

  /// The cheapest boundary with references on both sides.
  BinSplit best() const;
  bool goes_left(const kdtree::Reference& ref, const BinSplit& split) const;

 private:
  struct Bin {
    Lanes lo, hi;  // bounds, as in LaneBox
    std::uint32_t count;
  };
  std::uint32_t bin(float center, std::size_t axis) const {
    const float at = (center - lo_[axis]) * per_width_[axis];
    return static_cast<std::uint32_t>(
        static_cast<std::int32_t>(at > 0 ? (at < last_ ? at : last_) : 0.0f));
  }

  std::array<float, 3> lo_{}, per_width_{};  // per_width 0: no bins
  float last_ = 0;
  std::uint32_t bins_ = 0;
  std::array<std::array<Bin, kMaxBins>, 3> counted_;  // only the first bins_ are set
};

/// Splits each list at the boundary with the least SAH cost, among `bins` bins of equal width over
/// the centers of its boxes, on all three axes. Shorter lists have as many bins as references. A
/// list whose centers all coincide is halved in its order. `refs` is reordered to the order of the
/// leaves.
///
/// Touches: a pass to bin and a pass to divide each list. Parallel in the caller's arena; the
/// result does not depend on the number of threads.
BvhChild grow_binned(std::span<kdtree::Reference> refs, const BvhLeafRule& leaf, std::uint32_t bins,
                     BvhGrowth& growth, kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh

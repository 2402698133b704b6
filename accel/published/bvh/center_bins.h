// Bins over the centers of boxes: how many lie in each, and what they span.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/kdtree/reference.h"
#include "accel/published/bvh/lanes.h"

namespace sightline::accel::published::bvh {

/// What a list spans: its boxes, and their centers.
struct ListSpan {
  LaneBox boxes, centers;

  void add(const kdtree::Reference& ref);
  void grow(const ListSpan& o) {
    boxes.grow(o.boxes);
    centers.grow(o.centers);
  }
};

/// Where a list is divided: bins up to `last_left` go left.
struct BinSplit {
  std::size_t axis = 0;
  std::uint32_t last_left = 0;
  double sum = 0;  ///< Of half area times references, over both children.
  bool found = false;
};

class CenterBins {
 public:
  static constexpr std::uint32_t kMaxBins = 256;

  /// `bins` bins an axis over these centers, 2 to kMaxBins. An axis along which they coincide has
  /// none.
  CenterBins(const LaneBox& centers, std::uint32_t bins);

  void add(std::span<const kdtree::Reference> refs);
  CenterBins& operator+=(const CenterBins& o);

  /// The cheapest boundary that leaves something on both sides.
  BinSplit best() const;
  bool goes_left(const kdtree::Reference& ref, const BinSplit& split) const;

 private:
  struct Bin {
    Lanes lo, hi;  // as in LaneBox
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
  std::array<std::array<Bin, kMaxBins>, 3> counted_;  // as many as are used are set
};

}  // namespace sightline::accel::published::bvh

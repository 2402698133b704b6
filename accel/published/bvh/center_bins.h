// Bins over the centers of boxes: the number of boxes in each, and their bounds.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/kdtree/reference.h"
#include "accel/published/bvh/lanes.h"

namespace sightline::accel::published::bvh {

/// Bounds of a list: of its boxes, and of their centers.
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
  double sum = 0;  ///< Sum over both children of half area times references.
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
  std::array<std::array<Bin, kMaxBins>, 3> counted_;  // only the first bins_ are set
};

}  // namespace sightline::accel::published::bvh

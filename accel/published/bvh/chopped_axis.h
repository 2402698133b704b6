// Bins along an axis, with the bounds of the parts of triangles that lie in each. Source: Stich et
// al. 2009, section 4.2.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "accel/published/bvh/center_lists.h"
#include "accel/published/bvh/lanes.h"

namespace sightline::accel::published::bvh {

/// A split by the plane x[axis] = position. By default none.
struct SpatialSplit {
  std::size_t axis = 0;
  float position = 0;
  std::size_t left = 0, right = 0;  ///< References that overlap each side.
  /// Sum over both children of half area times references.
  double sum = std::numeric_limits<double>::infinity();

  bool found() const { return left > 0; }
};

/// The references on one side of a plane.
struct SideSum {
  LaneBox box;
  std::size_t references = 0;
  double area = 0;  ///< Half the surface of the box; 0 if there are no references.

  double cost() const { return area * static_cast<double>(references); }
};

/// Bins between ascending planes; parts below the first and above the last plane are ignored.
/// Bounds are those of clipped triangles, off by roundings of a float: they only estimate the cost
/// of splits. Counts are exact: a fragment that begins at a plane is above it, one that ends there
/// is below.
class ChoppedAxis {
 public:
  static constexpr std::size_t kMostBins = 16;

  /// `planes`: 2 to kMostBins + 1, finite.
  ChoppedAxis(std::size_t axis, std::span<const float> planes);

  std::size_t bins() const { return bins_; }
  float plane(std::size_t i) const { return planes_[i]; }

  /// Whether a fragment overlaps the bins.
  bool meets(const Fragment& f) const {
    return f.lo[axis_] < planes_[bins_] && f.hi[axis_] > planes_[0];
  }
  /// The range of a fragment: 0 is below the first plane, i between planes i - 1 and i, bins() + 1
  /// above the last.
  struct Span {
    std::size_t first, last;
    bool is_cut() const { return first < last; }
  };
  Span span(const Fragment& f) const {
    const std::size_t first = bin_above(f.lo[axis_]);
    return {first, std::max(first, bin_below(f.hi[axis_]))};
  }
  /// Adds a fragment that overlaps the bins. `corners`: of the part of its triangle; not read
  /// unless span.is_cut().
  void add(const Fragment& f, const Span& span, std::span<const Lanes> corners);
  /// Adds the contents of bins between the same planes.
  void merge(const ChoppedAxis& o);

  /// The references on each side of plane i, given those beyond the bins.
  struct Sides {
    std::array<SideSum, kMostBins + 1> left, right;
  };
  Sides sides(const SideSum& beyond_left, const SideSum& beyond_right) const;

  /// Bounds of the parts in a bin; empty for none.
  LaneBox bounds(std::size_t bin) const;

 private:
  /// The bin of a fragment that begins at x, and of one that ends there.
  std::size_t bin_above(float x) const {
    std::size_t bin = guess(x);
    while (bin > 0 && x < planes_[bin - 1]) --bin;
    while (bin <= bins_ && x >= planes_[bin]) ++bin;
    return bin;
  }
  std::size_t bin_below(float x) const {
    std::size_t bin = guess(x);
    while (bin > 0 && x <= planes_[bin - 1]) --bin;
    while (bin <= bins_ && x > planes_[bin]) ++bin;
    return bin;
  }
  std::size_t guess(float x) const {
    const float at = (x - planes_[0]) * per_width_ + 1;
    return static_cast<std::size_t>(at > 0 ? (at < most_ ? at : most_) : 0.0f);
  }
  void chop(std::span<const Lanes> corners, const Span& span);

  std::size_t axis_, bins_;
  float per_width_, most_;
  std::array<float, kMostBins + 1> planes_;
  std::array<LaneBox, kMostBins + 2>
      inside_;                               ///< Bounds of corners and of whole fragments, by bin.
  std::array<LaneBox, kMostBins + 1> cuts_;  ///< Bounds of the points where edges cross, by plane.
  std::array<std::uint32_t, kMostBins + 2> enter_{},
      leave_{};  ///< Fragments that begin and end there, by bin.
};

}  // namespace sightline::accel::published::bvh

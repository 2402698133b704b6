// Bins along an axis, with the bounds of the parts of triangles that lie in each. Source: Stich et
// al. 2009, section 4.2.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/published/bvh/center_lists.h"
#include "accel/published/bvh/lanes.h"

namespace sightline::accel::published::bvh {

/// A split by the plane x[axis] = position. There is none by default.
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
class SpatialBins {
 public:
  static constexpr std::size_t kMostBins = 16;

  /// Makes empty bins between `planes`, 2 to kMostBins + 1 of them, finite and ascending.
  SpatialBins(std::size_t axis, std::span<const float> planes);

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
  /// Adds a fragment that overlaps the bins. `corners` are those of the part of its triangle; they
  /// are read only if span.is_cut().
  void add(const Fragment& f, const Span& span, std::span<const Lanes> corners);
  /// Adds the contents of bins between the same planes.
  void merge(const SpatialBins& o);

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

/// The corners of one fragment. They are clipped in float, and off by roundings: they serve
/// estimates only.
class FragmentCorners {
 public:
  FragmentCorners(const geometry::MeshView& mesh, const Fragment& fragment) {
    const geometry::Face& f = mesh.faces[fragment.id()];
    auto& whole = at_[0];
    for (const std::uint32_t vertex : f) whole[size_++] = lanes(mesh.vertices[vertex]);
    const Lanes lo = least(least(whole[0], whole[1]), whole[2]);
    const Lanes hi = greatest(greatest(whole[0], whole[1]), whole[2]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (lo[axis] < fragment.lo[axis]) cut(axis, fragment.lo[axis], 1);
      if (hi[axis] > fragment.hi[axis]) cut(axis, fragment.hi[axis], -1);
    }
  }

  std::span<const Lanes> all() const { return {at_[now_].data(), size_}; }

 private:
  /// Keeps the part with sign * (x[axis] - position) >= 0.
  void cut(std::size_t axis, float position, float sign) {
    if (size_ == 0) return;
    const auto& from = at_[now_];
    auto& kept = at_[1 - now_];
    std::size_t n = 0;
    Lanes p = from[size_ - 1];
    float dp = sign * (p[axis] - position);
    for (std::size_t i = 0; i < size_; ++i) {
      const Lanes q = from[i];
      const float dq = sign * (q[axis] - position);
      if ((dp > 0 && dq < 0) || (dp < 0 && dq > 0)) {
        kept[n] = p + (q - p) * all_lanes(dp / (dp - dq));
        kept[n++][axis] = position;
      }
      if (dq >= 0) kept[n++] = q;
      p = q;
      dp = dq;
    }
    now_ = 1 - now_;
    size_ = n;
  }

  /// Input and output of a cut, in turn. A triangle has three corners, and each of six cuts adds at
  /// most one.
  std::array<std::array<Lanes, 9>, 2> at_;
  std::size_t now_ = 0, size_ = 0;
};

/// The corners of all fragments of a list, kept for several passes over it.
class ListCorners {
 public:
  void set(const geometry::MeshView& mesh, std::span<const Fragment> list) {
    corners_.clear();
    end_.clear();
    for (const Fragment& f : list) {
      const FragmentCorners corners(mesh, f);
      corners_.insert(corners_.end(), corners.all().begin(), corners.all().end());
      end_.push_back(corners_.size());
    }
  }
  std::span<const Lanes> of(std::size_t index) const {
    const std::size_t begin = index > 0 ? end_[index - 1] : 0;
    return std::span(corners_).subspan(begin, end_[index] - begin);
  }

 private:
  std::vector<Lanes> corners_;
  std::vector<std::size_t> end_;
};

}  // namespace sightline::accel::published::bvh

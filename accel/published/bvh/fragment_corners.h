// The outline of the part of a triangle in a fragment.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/published/bvh/center_lists.h"
#include "accel/published/bvh/lanes.h"

namespace sightline::accel::published::bvh {

/// The corners of one fragment. Clipped in float: off by roundings, for estimates only.
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

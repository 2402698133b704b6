// The outline of what a fragment holds of its triangle.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "accel/bvh/center_lists.h"
#include "accel/bvh/lanes.h"
#include "accel/geometry/mesh_view.h"

namespace sightline::accel {

/// Six cuts add at most one corner each to three.
class FragmentCorners {
 public:
  /// Cut in float: off by roundings, for estimates only.
  FragmentCorners(const MeshView& mesh, const Fragment& fragment) {
    const Face& f = mesh.faces[fragment.id()];
    for (const std::uint32_t vertex : f) at_[size_++] = lanes(mesh.vertices[vertex]);
    const Lanes lo = least(least(at_[0], at_[1]), at_[2]);
    const Lanes hi = greatest(greatest(at_[0], at_[1]), at_[2]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (lo[axis] < fragment.lo[axis]) cut(axis, fragment.lo[axis], 1);
      if (hi[axis] > fragment.hi[axis]) cut(axis, fragment.hi[axis], -1);
    }
  }

  std::span<const Lanes> all() const { return {at_.data(), size_}; }

 private:
  /// Keeps what has sign * (x[axis] - position) >= 0.
  void cut(std::size_t axis, float position, float sign) {
    std::array<Lanes, 9> kept;
    std::size_t n = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      const Lanes p = at_[i], q = at_[i + 1 == size_ ? 0 : i + 1];
      const float dp = sign * (p[axis] - position), dq = sign * (q[axis] - position);
      if (dp >= 0) kept[n++] = p;
      if ((dp > 0 && dq < 0) || (dp < 0 && dq > 0)) {
        kept[n] = p + (q - p) * all_lanes(dp / (dp - dq));
        kept[n++][axis] = position;
      }
    }
    at_ = kept;
    size_ = n;
  }

  std::array<Lanes, 9> at_;
  std::size_t size_ = 0;
};

}  // namespace sightline::accel

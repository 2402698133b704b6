// A node: up to eight children, their boxes in columns.
#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "accel/geometry/aabb.h"
#include "accel/kdtree/slot.h"

namespace sightline::accel::kdtree {

inline constexpr std::size_t kWidth = 8;

/// Boxes are in the frame of their tree (wide::Frame). The box of a child that does not exist
/// begins at +inf and ends at -inf, so that no ray meets it. Children that exist come first. The
/// boxes never change once other threads see the node; children that are not finished do.
struct alignas(64) WideNode {
  WideNode() {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds[2 * axis].fill(std::numeric_limits<float>::infinity());
      bounds[2 * axis + 1].fill(-std::numeric_limits<float>::infinity());
    }
  }

  /// For each axis, the lower bounds of all children, then the upper ones.
  std::array<std::array<float, kWidth>, 6> bounds;
  std::array<AtomicSlot, kWidth> children{};

  Slot child(std::size_t i) const { return load(children[i]); }
  /// The slot of child i, for threads that replace what it holds.
  AtomicSlot& slot(std::size_t i) const { return const_cast<AtomicSlot&>(children[i]); }
  geometry::Aabb box(std::size_t i) const {
    return {{bounds[0][i], bounds[2][i], bounds[4][i]}, {bounds[1][i], bounds[3][i], bounds[5][i]}};
  }
  void set_box(std::size_t i, const geometry::Aabb& box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds[2 * axis][i] = box.lo[axis];
      bounds[2 * axis + 1][i] = box.hi[axis];
    }
  }
};
static_assert(sizeof(WideNode) == 256);

/// The most nodes on a path in a tree above finished subtrees, and again in each of these: the
/// stack of a walk has room for both.
inline constexpr std::size_t kMostLevels = 128;

}  // namespace sightline::accel::kdtree

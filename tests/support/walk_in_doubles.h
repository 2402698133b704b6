// The walk of one ray through a wide tree in doubles: for triangle tests other than the product's.
#pragma once

#include <array>
#include <cstddef>

#include "accel/blocks/block.h"
#include "accel/kdtree/tree_ray.h"
#include "accel/kdtree/walk_counters.h"
#include "accel/wide/wide_tree.h"

namespace sightline::tests {

/// A child's box in the tree's coordinates. Exact, as the differences to the center are.
inline accel::geometry::Aabb box_of(const accel::wide::WideNode& node, std::size_t i,
                                    const accel::geometry::Vec3f& center) {
  accel::geometry::Aabb box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.lo[axis] = node.bounds[2 * axis][i] + center[axis];
    box.hi[axis] = node.bounds[2 * axis + 1][i] + center[axis];
  }
  return box;
}

/// Calls visit.test(id) for the triangles of all blocks whose boxes the ray may meet before
/// visit.limit(), until one returns true; then returns true.
template <class Visit>
bool walk_in_doubles(const accel::wide::WideTree& tree, const accel::kdtree::TreeRay& ray,
                     Visit& visit, accel::kdtree::WalkCounters& counters) {
  using accel::wide::Child;
  using accel::wide::kWidth;
  std::array<Child, accel::wide::kMostLevels*(kWidth - 1) + 1> stack;
  std::size_t waiting = 0;
  stack[waiting++] = tree.root();
  while (waiting > 0) {
    const Child at = stack[--waiting];
    if (at.is_block()) {
      const accel::blocks::Block block(at.block());
      for (std::size_t i = 0; i < block.triangles; ++i) {
        if (visit.test(block.id(i))) return true;
      }
      continue;
    }
    ++counters.steps;
    const accel::wide::WideNode& node = *at.node();
    for (std::size_t i = 0; i < kWidth && node.children[i]; ++i) {
      if (may_meet(ray, box_of(node, i, tree.center()), visit.limit()))
        stack[waiting++] = node.children[i];
    }
  }
  return false;
}

}  // namespace sightline::tests

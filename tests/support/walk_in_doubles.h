// The walk of one ray through a finished tree in doubles: for triangle tests other than the
// product's.
#pragma once

#include <array>
#include <cstddef>

#include "accel/blocks/block.h"
#include "accel/kdtree/tree_ray.h"
#include "accel/kdtree/walk_counters.h"
#include "accel/wide/wide_tree.h"

namespace sightline::tests {

/// The box of a child in the tree's coordinates. Exact, as the differences to the center are.
inline accel::geometry::Aabb box_of(const accel::kdtree::WideNode& node, std::size_t i,
                                    const accel::geometry::Vec3f& center) {
  const accel::geometry::Aabb box = node.box(i);
  return {box.lo + center, box.hi + center};
}

/// Calls visit.test(id) for the triangles of all blocks whose boxes the ray may meet before
/// visit.limit(), until one returns true; then returns true.
template <class Visit>
bool walk_in_doubles(const accel::wide::WideTree& tree, const accel::kdtree::TreeRay& ray,
                     Visit& visit, accel::kdtree::WalkCounters& counters) {
  using accel::kdtree::kWidth;
  std::array<accel::kdtree::Slot, accel::kdtree::kMostLevels*(kWidth - 1) + 1> stack;
  std::size_t waiting = 0;
  stack[waiting++] = tree.root();
  while (waiting > 0) {
    const accel::kdtree::Slot at = stack[--waiting];
    if (at.is_block()) {
      const accel::blocks::Block block(at.words());
      for (std::size_t i = 0; i < block.triangles; ++i) {
        if (visit.test(block.id(i))) return true;
      }
      continue;
    }
    ++counters.steps;
    for (std::size_t i = 0; i < kWidth && at.node()->child(i); ++i) {
      if (may_meet(ray, box_of(*at.node(), i, tree.center()), visit.limit()))
        stack[waiting++] = at.node()->child(i);
    }
  }
  return false;
}

}  // namespace sightline::tests

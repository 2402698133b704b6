// The walk of one ray through a tree in doubles, which grows nothing: for triangle tests other than
// the product's, and to see what a ray meets.
#pragma once

#include <cstddef>
#include <vector>

#include "accel/blocks/block.h"
#include "accel/kdtree/kd_tree.h"
#include "accel/kdtree/tree_ray.h"
#include "accel/wide/frame.h"
#include "accel/wide/wide_tree.h"

namespace sightline::tests {

/// The box of a child in the tree's coordinates. Exact, as what frames do to floats is.
inline accel::geometry::Aabb box_of(const accel::kdtree::WideNode& node, std::size_t i,
                                    const accel::wide::Frame& frame) {
  const accel::geometry::Aabb box = node.box(i);
  const float unit = 1 / frame.scale;
  return {box.lo * unit + frame.center, box.hi * unit + frame.center};
}

/// Visits all whose boxes the ray may meet before visit.limit(). The calling thread is pinned, and
/// the tree has bounds. `visit` supplies:
///   void reference(id)                          a triangle of a block, an id of a list
///   void deferred(const kdtree::DeferredCell&)  what is not built
///   double limit()
template <class Visit>
void walk_in_doubles(const accel::kdtree::KdTree& tree, const accel::kdtree::TreeRay& ray,
                     Visit& visit) {
  const accel::wide::Frame frame = accel::wide::frame_of(tree.bounds());
  std::vector<accel::kdtree::Slot> stack{accel::kdtree::load(tree.root())};
  while (!stack.empty()) {
    const accel::kdtree::Slot at = stack.back();
    stack.pop_back();
    if (at.is_block()) {
      const accel::blocks::Block block(at.words());
      for (std::size_t i = 0; i < block.triangles; ++i) visit.reference(block.id(i));
    } else if (at.is_list()) {
      for (const std::uint32_t id : at.list()) visit.reference(id);
    } else if (at.is_finished()) {
      stack.push_back(at.finished()->root());
    } else if (at.is_deferred()) {
      visit.deferred(*at.cell());
    } else {
      for (std::size_t i = 0; i < accel::kdtree::kWidth && at.node()->child(i); ++i) {
        if (may_meet(ray, box_of(*at.node(), i, frame), visit.limit()))
          stack.push_back(at.node()->child(i));
      }
    }
  }
}

}  // namespace sightline::tests

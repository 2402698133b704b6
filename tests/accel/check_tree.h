// The invariants of every kd-tree: cells tile the bounds, and a leaf holds exactly its cell's members.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "accel/tree/kd_tree.h"

namespace sightline::tests {

/// `bounds[id]` is the builder's box of a reference; references without one have an empty box.
inline void check_cell(const accel::KdTree& tree, accel::Slot slot, const accel::Aabb& cell, int depth,
                       const std::vector<accel::Aabb>& bounds) {
  ASSERT_LE(depth, accel::kMaxTreeDepth);
  if (slot.is_binary()) {
    const auto axis = static_cast<std::size_t>(slot.axis());
    ASSERT_GT(slot.position(), cell.lo[axis]);
    ASSERT_LT(slot.position(), cell.hi[axis]);
    const accel::HalvedCell halves = accel::halve(cell, slot.axis(), slot.position());
    check_cell(tree, accel::load(tree.children(slot)[0]), halves.left, depth + 1, bounds);
    check_cell(tree, accel::load(tree.children(slot)[1]), halves.right, depth + 1, bounds);
    return;
  }
  std::vector<std::uint32_t> held, members;
  if (slot.is_unbuilt()) {
    if (!slot.cell()->listed) return;
    for (const accel::BoxRef& ref : slot.cell()->list.all()) held.push_back(ref.id);
    ASSERT_EQ(slot.cell()->box, cell);
  } else {
    std::uint32_t storage;
    if (slot.leaf_count() > 0) {
      for (const std::uint32_t id : tree.leaf(slot, storage)) held.push_back(id);
    }
  }
  for (std::size_t id = 0; id < bounds.size(); ++id) {
    if (!bounds[id].empty() && accel::is_member(bounds[id], cell)) members.push_back(static_cast<std::uint32_t>(id));
  }
  std::sort(held.begin(), held.end());
  ASSERT_EQ(held, members);
}

inline void check_tree(const accel::KdTree& tree, const std::vector<accel::Aabb>& bounds) {
  check_cell(tree, accel::load(tree.root()), tree.bounds(), 0, bounds);
}

}  // namespace sightline::tests

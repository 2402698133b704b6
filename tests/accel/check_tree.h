// Checks the invariants of every kd-tree: cells tile the bounds, and a leaf or a finished subtree
// holds exactly its cell's members, or, if the builder clips, all references that a ray can meet
// there.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "accel/kdtree/kd_tree.h"
#include "tests/accel/wide/boxed_blocks.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

inline std::vector<std::uint32_t> ids_of(const accel::kdtree::CellList& list) {
  if (list.is_compact()) return {list.ids().begin(), list.ids().end()};
  std::vector<std::uint32_t> ids;
  list.any_part([&](std::span<const accel::kdtree::Reference> refs) {
    for (const accel::kdtree::Reference& ref : refs) ids.push_back(ref.id);
    return false;
  });
  return ids;
}

inline const accel::wide::WideTree& wide_tree(accel::kdtree::Slot finished) {
  return dynamic_cast<const accel::wide::WideTree&>(*finished.finished());
}

/// A finished subtree: every corner that lies in the cell is in the box of a block that holds the
/// face. Sets `held` to its faces.
inline void check_finished(const accel::wide::WideTree& tree, const accel::geometry::Aabb& cell,
                           const TestMesh& mesh, const std::vector<accel::geometry::Aabb>& bounds,
                           std::vector<std::uint32_t>& held) {
  std::vector<BoxedBlock> boxed;
  ASSERT_NO_FATAL_FAILURE(list_blocks(tree, cell, mesh, bounds, boxed));
  held = ids_of(boxed);
  for (const std::uint32_t id : held) {
    for (const std::uint32_t v : mesh.faces[id]) {
      const accel::geometry::Vec3f& corner = mesh.vertices[v];
      ASSERT_TRUE(!holds_point(cell, corner) || is_held_at(boxed, corner, id)) << "face " << id;
    }
  }
}

/// `bounds[id]` is the builder's box of a reference; references without one have an empty box.
inline void check_cell(const accel::kdtree::KdTree& tree, accel::kdtree::Slot slot,
                       const accel::geometry::Aabb& cell, int depth, const TestMesh& mesh,
                       const std::vector<accel::geometry::Aabb>& bounds) {
  ASSERT_LE(depth, accel::kdtree::kMaxTreeDepth);
  if (slot.is_binary()) {
    const auto axis = static_cast<std::size_t>(slot.axis());
    ASSERT_GT(slot.position(), cell.lo[axis]);
    ASSERT_LT(slot.position(), cell.hi[axis]);
    const accel::geometry::HalvedCell halves =
        accel::geometry::halve(cell, slot.axis(), slot.position());
    check_cell(tree, accel::kdtree::load(tree.children(slot)[0]), halves.left, depth + 1, mesh,
               bounds);
    check_cell(tree, accel::kdtree::load(tree.children(slot)[1]), halves.right, depth + 1, mesh,
               bounds);
    return;
  }
  std::vector<std::uint32_t> held, members;
  if (slot.is_deferred()) {
    ASSERT_EQ(slot.cell()->box, cell);
    if (!slot.cell()->has_list || slot.cell()->openable) return;
    held = ids_of(slot.cell()->list);
  } else if (slot.is_finished()) {
    ASSERT_NO_FATAL_FAILURE(check_finished(wide_tree(slot), cell, mesh, bounds, held));
  } else {
    std::uint32_t storage;
    if (slot.leaf_count() > 0) {
      for (const std::uint32_t id : tree.leaf(slot, storage)) held.push_back(id);
    }
  }
  for (std::size_t id = 0; id < bounds.size(); ++id) {
    if (!bounds[id].empty() && accel::geometry::is_member(bounds[id], cell))
      members.push_back(static_cast<std::uint32_t>(id));
  }
  std::sort(held.begin(), held.end());
  ASSERT_EQ(held, members);
}

inline void check_tree(const accel::kdtree::KdTree& tree, const TestMesh& mesh,
                       const std::vector<accel::geometry::Aabb>& bounds) {
  check_cell(tree, accel::kdtree::load(tree.root()), tree.bounds(), 0, mesh, bounds);
}

/// Whether some leaf or block whose closed cell contains the point holds the reference.
inline bool is_held_at(const accel::kdtree::KdTree& tree, accel::kdtree::Slot slot,
                       const accel::geometry::Aabb& cell, const accel::geometry::Vec3f& point,
                       std::uint32_t id) {
  if (!holds_point(cell, point)) return false;
  if (slot.is_binary()) {
    const accel::geometry::HalvedCell halves =
        accel::geometry::halve(cell, slot.axis(), slot.position());
    return is_held_at(tree, accel::kdtree::load(tree.children(slot)[0]), halves.left, point, id) ||
           is_held_at(tree, accel::kdtree::load(tree.children(slot)[1]), halves.right, point, id);
  }
  if (slot.is_deferred()) {
    if (!slot.cell()->has_list || slot.cell()->openable) return true;
    const std::vector<std::uint32_t> ids = ids_of(slot.cell()->list);
    return std::find(ids.begin(), ids.end(), id) != ids.end();
  }
  if (slot.is_finished()) {
    const accel::wide::WideTree& subtree = wide_tree(slot);
    std::vector<BoxedBlock> boxed;
    list_blocks(subtree.root(), cell, subtree.center(), boxed);
    return is_held_at(boxed, point, id);
  }
  if (slot.leaf_count() == 0) return false;
  std::uint32_t storage;
  const auto ids = tree.leaf(slot, storage);
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

inline void check_closed_cell(const accel::kdtree::KdTree& tree, accel::kdtree::Slot slot,
                              const accel::geometry::Aabb& cell, int depth, const TestMesh& mesh,
                              const std::vector<accel::geometry::Aabb>& bounds) {
  ASSERT_LE(depth, accel::kdtree::kMaxTreeDepth);
  if (slot.is_binary()) {
    const auto axis = static_cast<std::size_t>(slot.axis());
    ASSERT_GE(slot.position(), cell.lo[axis]);
    ASSERT_LE(slot.position(), cell.hi[axis]);
    const accel::geometry::HalvedCell halves =
        accel::geometry::halve(cell, slot.axis(), slot.position());
    check_closed_cell(tree, accel::kdtree::load(tree.children(slot)[0]), halves.left, depth + 1,
                      mesh, bounds);
    check_closed_cell(tree, accel::kdtree::load(tree.children(slot)[1]), halves.right, depth + 1,
                      mesh, bounds);
    return;
  }
  std::vector<std::uint32_t> held;
  if (slot.is_deferred()) {
    ASSERT_EQ(slot.cell()->box, cell);
    if (!slot.cell()->openable) held = ids_of(slot.cell()->list);
  } else if (slot.is_finished()) {
    ASSERT_NO_FATAL_FAILURE(check_finished(wide_tree(slot), cell, mesh, bounds, held));
  } else if (slot.leaf_count() > 0) {
    std::uint32_t storage;
    for (const std::uint32_t id : tree.leaf(slot, storage)) held.push_back(id);
  }
  std::sort(held.begin(), held.end());
  ASSERT_EQ(std::adjacent_find(held.begin(), held.end()), held.end());
  for (const std::uint32_t id : held) {
    for (std::size_t a = 0; a < 3; ++a) {
      ASSERT_LE(bounds[id].lo[a], cell.hi[a]);
      ASSERT_GE(bounds[id].hi[a], cell.lo[a]);
    }
  }
}

/// For builders that clip or choose the side of flat boxes, as their papers do: cells (some of them
/// flat) tile the bounds; a leaf holds no reference twice and none that does not touch its closed
/// cell; and every corner of every face lies in the closed cell of a leaf that holds the face, or
/// in the box of a block that does. `bounds` as above.
inline void check_closed_tree(const accel::kdtree::KdTree& tree, const TestMesh& mesh,
                              const std::vector<accel::geometry::Aabb>& bounds) {
  check_closed_cell(tree, accel::kdtree::load(tree.root()), tree.bounds(), 0, mesh, bounds);
  for (std::size_t id = 0; id < bounds.size(); ++id) {
    if (bounds[id].empty()) continue;
    for (const std::uint32_t v : mesh.faces[id]) {
      ASSERT_TRUE(is_held_at(tree, accel::kdtree::load(tree.root()), tree.bounds(),
                             mesh.vertices[v], static_cast<std::uint32_t>(id)))
          << "face " << id;
    }
  }
}

}  // namespace sightline::tests

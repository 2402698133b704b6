// Checks the invariants of every tree: a cell or a finished subtree holds exactly its cell's
// members, or, if the builder clips, all references that a ray can meet there; a node's box of a
// cell lies in the cell.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "accel/blocks/frame.h"
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

/// Calls check(slot, cell) for what lies below the nodes: cells, finished subtrees and empty lists.
/// `cell`: the box of the slot; of a cell, its own, which nodes know as far as something lies in
/// it.
template <class Check>
void each_cell(accel::kdtree::Slot slot, const accel::geometry::Aabb& cell, int depth,
               const accel::wide::Frame& frame, const Check& check) {
  ASSERT_LE(depth, accel::kdtree::kMaxTreeDepth);
  if (slot.is_deferred()) {
    ASSERT_TRUE(lies_in(cell, slot.cell()->box));
    return check(slot, slot.cell()->box);
  }
  if (!slot.is_node()) return check(slot, cell);
  for (std::size_t i = 0; i < accel::kdtree::kWidth && slot.node()->child(i); ++i) {
    const accel::geometry::Aabb child = box_of(*slot.node(), i, frame);
    ASSERT_NO_FATAL_FAILURE(each_cell(slot.node()->child(i), child, depth + 1, frame, check));
  }
}

template <class Check>
void each_cell(const accel::kdtree::KdTree& tree, const Check& check) {
  each_cell(accel::kdtree::load(tree.root()), tree.bounds(), 0,
            {accel::blocks::frame_center(tree.bounds()), {}}, check);
}

/// Sets `held` to what a cell holds, ascending; false if its list is not made.
inline bool read_held(accel::kdtree::Slot slot, const accel::geometry::Aabb& cell,
                      const TestMesh& mesh, const std::vector<accel::geometry::Aabb>& bounds,
                      std::vector<std::uint32_t>& held) {
  if (slot.is_finished()) {
    check_finished(wide_tree(slot), cell, mesh, bounds, held);
  } else if (slot.is_deferred()) {
    if (!slot.cell()->has_list || slot.cell()->openable) return false;
    held = ids_of(slot.cell()->list);
  }
  std::sort(held.begin(), held.end());
  return true;
}

/// `bounds[id]` is the builder's box of a reference; references without one have an empty box.
inline void check_tree(const accel::kdtree::KdTree& tree, const TestMesh& mesh,
                       const std::vector<accel::geometry::Aabb>& bounds) {
  each_cell(tree, [&](accel::kdtree::Slot slot, const accel::geometry::Aabb& cell) {
    std::vector<std::uint32_t> held, members;
    if (!read_held(slot, cell, mesh, bounds, held)) return;
    for (std::size_t id = 0; id < bounds.size(); ++id) {
      if (!bounds[id].empty() && accel::geometry::is_member(bounds[id], cell))
        members.push_back(static_cast<std::uint32_t>(id));
    }
    ASSERT_EQ(held, members);
  });
}

/// For builders that clip: a cell holds no reference twice and none that does not touch its closed
/// box; and every corner of every face lies in the closed box of a cell that holds the face.
/// `bounds` as above.
inline void check_closed_tree(const accel::kdtree::KdTree& tree, const TestMesh& mesh,
                              const std::vector<accel::geometry::Aabb>& bounds) {
  std::vector<std::array<bool, 3>> covered(bounds.size());
  bool unknown = false;
  each_cell(tree, [&](accel::kdtree::Slot slot, const accel::geometry::Aabb& cell) {
    std::vector<std::uint32_t> held;
    unknown |= !read_held(slot, cell, mesh, bounds, held);
    ASSERT_EQ(std::adjacent_find(held.begin(), held.end()), held.end());
    for (const std::uint32_t id : held) {
      for (std::size_t a = 0; a < 3; ++a) {
        ASSERT_LE(bounds[id].lo[a], cell.hi[a]);
        ASSERT_GE(bounds[id].hi[a], cell.lo[a]);
      }
      for (std::size_t k = 0; k < 3; ++k)
        covered[id][k] |= holds_point(cell, mesh.vertices[mesh.faces[id][k]]);
    }
  });
  for (std::size_t id = 0; id < bounds.size() && !unknown; ++id) {
    if (bounds[id].empty()) continue;
    EXPECT_EQ(covered[id], (std::array<bool, 3>{true, true, true})) << "face " << id;
  }
}

}  // namespace sightline::tests

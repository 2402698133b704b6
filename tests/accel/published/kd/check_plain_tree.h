// Checks the invariants of plain kd-trees: cells tile the bounds, and a leaf holds exactly its
// cell's members, or, if the builder clips, all references that a ray can meet there.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "accel/kdtree/kd_tree.h"
#include "accel/published/kd/plain_cells.h"
#include "tests/accel/wide/boxed_blocks.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

/// The ids are sorted.
struct PlainLeaf {
  accel::geometry::Aabb cell;
  std::vector<std::uint32_t> ids;
};

/// What a leaf holds, also a failed one.
inline std::vector<std::uint32_t> ids_of(const accel::published::kd::PlainCells& cells,
                                         accel::published::kd::PlainNode leaf) {
  std::vector<std::uint32_t> ids;
  if (leaf.is_failed()) {
    for (const accel::kdtree::Reference& ref : cells.failed_leaf(leaf)) ids.push_back(ref.id);
  } else if (leaf.count() > 0) {
    std::uint32_t storage;
    const auto held = cells.leaf(leaf, storage);
    ids.assign(held.begin(), held.end());
  }
  std::sort(ids.begin(), ids.end());
  return ids;
}

/// Appends the leaves in order, and counts the inner nodes.
inline void collect_leaves(const accel::published::kd::PlainCells& cells,
                           accel::published::kd::PlainNode node, const accel::geometry::Aabb& cell,
                           int depth, std::size_t& inner, std::vector<PlainLeaf>& leaves) {
  ASSERT_LE(depth, accel::kdtree::kMaxTreeDepth);
  if (node.is_leaf()) return leaves.push_back({cell, ids_of(cells, node)});
  ++inner;
  ASSERT_GE(node.position(), cell.lo[node.axis()]);
  ASSERT_LE(node.position(), cell.hi[node.axis()]);
  const accel::geometry::HalvedCell halves =
      accel::geometry::halve(cell, static_cast<int>(node.axis()), node.position());
  const auto& [left, right] = cells.pairs.at(node.pair());
  collect_leaves(cells, left, halves.left, depth + 1, inner, leaves);
  collect_leaves(cells, right, halves.right, depth + 1, inner, leaves);
}

/// Every pair belongs to one node.
inline std::vector<PlainLeaf> leaves_of(const accel::published::kd::PlainCells& cells,
                                        const accel::geometry::Aabb& bounds) {
  std::vector<PlainLeaf> leaves;
  std::size_t inner = 0;
  collect_leaves(cells, cells.root, bounds, 0, inner, leaves);
  EXPECT_EQ(inner, cells.pairs.size());
  EXPECT_EQ(leaves.size(), cells.pairs.size() + 1);
  return leaves;
}

/// `boxes[id]` is the builder's box of a reference; references without one have an empty box.
inline void check_plain_tree(const accel::published::kd::PlainCells& cells,
                             const accel::geometry::Aabb& bounds, const TestMesh&,
                             const std::vector<accel::geometry::Aabb>& boxes) {
  for (const PlainLeaf& leaf : leaves_of(cells, bounds)) {
    std::vector<std::uint32_t> members;
    for (std::size_t id = 0; id < boxes.size(); ++id) {
      if (!boxes[id].empty() && accel::geometry::is_member(boxes[id], leaf.cell))
        members.push_back(static_cast<std::uint32_t>(id));
    }
    ASSERT_EQ(leaf.ids, members);
  }
}

/// For builders that clip or choose the side of flat boxes, as their papers do: cells (some of them
/// flat) tile the bounds; a leaf holds no reference twice and none that does not touch its closed
/// cell; and every corner of every face lies in the closed cell of a leaf that holds the face.
inline void check_closed_plain_tree(const accel::published::kd::PlainCells& cells,
                                    const accel::geometry::Aabb& bounds, const TestMesh& mesh,
                                    const std::vector<accel::geometry::Aabb>& boxes) {
  const std::vector<PlainLeaf> leaves = leaves_of(cells, bounds);
  std::vector<std::vector<std::size_t>> holding(boxes.size());
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const std::vector<std::uint32_t>& ids = leaves[i].ids;
    ASSERT_EQ(std::adjacent_find(ids.begin(), ids.end()), ids.end());
    for (const std::uint32_t id : ids) {
      holding.at(id).push_back(i);
      for (std::size_t a = 0; a < 3; ++a) {
        ASSERT_LE(boxes[id].lo[a], leaves[i].cell.hi[a]);
        ASSERT_GE(boxes[id].hi[a], leaves[i].cell.lo[a]);
      }
    }
  }
  for (std::size_t id = 0; id < boxes.size(); ++id) {
    if (boxes[id].empty()) continue;
    for (const std::uint32_t v : mesh.faces[id]) {
      ASSERT_TRUE(std::ranges::any_of(
          holding[id],
          [&](std::size_t leaf) { return holds_point(leaves[leaf].cell, mesh.vertices[v]); }))
          << "face " << id;
    }
  }
}

}  // namespace sightline::tests

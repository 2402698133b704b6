// The blocks of a wide tree with their boxes, checked on the way.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "accel/blocks/block.h"
#include "accel/blocks/frame.h"
#include "accel/wide/wide_tree.h"
#include "tests/support/scenes.h"
#include "tests/support/walk_in_doubles.h"

namespace sightline::tests {

/// A block with its box in coordinates of the mesh.
struct BoxedBlock {
  accel::geometry::Aabb box;
  accel::blocks::Block block;
};

inline bool lies_in(const accel::geometry::Aabb& inner, const accel::geometry::Aabb& outer) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(inner.lo[a] >= outer.lo[a] && inner.hi[a] <= outer.hi[a])) return false;
  }
  return true;
}

inline bool holds_point(const accel::geometry::Aabb& box, const accel::geometry::Vec3f& point) {
  return lies_in({point, point}, box);
}

/// Adds the blocks at and below a slot. Boxes lie in that of their parent, children come first in
/// their node, and no ray meets the box of one that does not exist.
inline void list_blocks(accel::kdtree::Slot at, const accel::geometry::Aabb& box,
                        const accel::wide::Frame& frame, std::vector<BoxedBlock>& out) {
  if (at.is_block()) {
    out.push_back({box, accel::blocks::Block(at.words())});
    return;
  }
  ASSERT_TRUE(at.is_node());
  const accel::kdtree::WideNode& node = *at.node();
  ASSERT_TRUE(node.child(0) && node.child(1));
  bool ended = false;
  for (std::size_t i = 0; i < accel::kdtree::kWidth; ++i) {
    if (!node.child(i)) {
      ended = true;
      for (std::size_t a = 0; a < 3; ++a) {
        ASSERT_EQ(node.bounds[2 * a][i], HUGE_VALF);
        ASSERT_EQ(node.bounds[2 * a + 1][i], -HUGE_VALF);
      }
      continue;
    }
    ASSERT_FALSE(ended);
    const accel::geometry::Aabb child = box_of(node, i, frame);
    ASSERT_TRUE(lies_in(child, box));
    ASSERT_NO_FATAL_FAILURE(list_blocks(node.child(i), child, frame, out));
  }
}

/// The blocks of a tree over a cell. A block holds no triangle twice, and each as the mesh has it;
/// `bounds[id]` of each meets the block's box.
inline void list_blocks(const accel::wide::WideTree& tree, const accel::geometry::Aabb& cell,
                        const TestMesh& mesh, const std::vector<accel::geometry::Aabb>& bounds,
                        std::vector<BoxedBlock>& out) {
  ASSERT_NO_FATAL_FAILURE(list_blocks(tree.root(), cell, {tree.center(), {}}, out));
  for (const auto& [box, block] : out) {
    std::vector<std::uint32_t> ids;
    for (std::size_t i = 0; i < block.triangles; ++i) {
      const std::uint32_t id = block.id(i);
      ids.push_back(id);
      for (std::size_t a = 0; a < 3; ++a) {
        ASSERT_LE(bounds[id].lo[a], box.hi[a]);
        ASSERT_GE(bounds[id].hi[a], box.lo[a]);
      }
      for (std::size_t k = 0; k < 3; ++k) {
        const accel::geometry::Vec3f v = block.vertex(block.corner(k)[i]),
                                     &expected = mesh.vertices[mesh.faces[id][k]];
        for (std::size_t a = 0; a < 3; ++a)
          ASSERT_EQ(v[a], accel::blocks::relative(expected[a], tree.center()[a]));
      }
    }
    std::sort(ids.begin(), ids.end());
    ASSERT_EQ(std::adjacent_find(ids.begin(), ids.end()), ids.end());
  }
}

/// The ids in some blocks, ascending, each once.
inline std::vector<std::uint32_t> ids_of(const std::vector<BoxedBlock>& boxed) {
  std::vector<std::uint32_t> ids;
  for (const BoxedBlock& at : boxed) {
    for (std::size_t i = 0; i < at.block.triangles; ++i) ids.push_back(at.block.id(i));
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

/// Whether a block that holds the triangle has the point in its box.
inline bool is_held_at(const std::vector<BoxedBlock>& boxed, const accel::geometry::Vec3f& point,
                       std::uint32_t id) {
  return std::any_of(boxed.begin(), boxed.end(), [&](const BoxedBlock& at) {
    if (!holds_point(at.box, point)) return false;
    for (std::size_t i = 0; i < at.block.triangles; ++i) {
      if (at.block.id(i) == id) return true;
    }
    return false;
  });
}

}  // namespace sightline::tests

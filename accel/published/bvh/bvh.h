// The bounding volume hierarchy as it is kept: nodes of two children each, and the ids its leaves
// hold. Built whole and not changed afterwards.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/geometry/aabb.h"

namespace sightline::accel::published::bvh {

/// What hangs at a place in the hierarchy: an inner node or a leaf, and the box around what is
/// below. Made without arguments: an empty leaf.
struct BvhChild {
  geometry::Aabb box{};
  std::uint32_t first = 0;  ///< Inner: the place of its node. Leaf: of its first id.
  std::uint32_t count = 0;  ///< Ids in the leaf.
  bool inner = false;
};

/// An inner node. It holds its children's boxes, so that one cache line decides about both; the two
/// numbers for the same face of both boxes stand side by side, as they are computed with.
struct alignas(64) BvhNode {
  static constexpr std::uint32_t kInner = 0xffffffffu;

  /// [axis] lower, [3 + axis] upper bounds, [child].
  std::array<std::array<float, 2>, 6> bounds{};
  std::array<std::uint32_t, 2> first{};
  std::array<std::uint32_t, 2> count{};  ///< kInner for an inner node.

  BvhChild child(std::size_t side) const {
    BvhChild c;
    c.first = first[side];
    c.count = count[side];
    for (std::size_t a = 0; a < 3; ++a) {
      c.box.lo[a] = bounds[a][side];
      c.box.hi[a] = bounds[3 + a][side];
    }
    c.inner = c.count == kInner;
    if (c.inner) c.count = 0;
    return c;
  }
  void set(std::size_t side, const BvhChild& c) {
    for (std::size_t a = 0; a < 3; ++a) {
      bounds[a][side] = c.box.lo[a];
      bounds[3 + a][side] = c.box.hi[a];
    }
    first[side] = c.first;
    count[side] = c.inner ? kInner : c.count;
  }
};
static_assert(sizeof(BvhNode) == 64);

/// Nodes stand in depth-first order, left children first; ids in the order of their leaves. A
/// triangle whose reference was split is named by several leaves.
///
/// Boxes hold all of what of their triangles they are responsible for: every point of a triangle
/// lies in the box of a leaf that names it, and in all boxes above that leaf.
struct Bvh {
  BvhChild root;
  std::vector<BvhNode> nodes;
  std::vector<std::uint32_t> ids;

  std::span<const std::uint32_t> leaf(const BvhChild& child) const {
    return std::span(ids).subspan(child.first, child.count);
  }
  std::uint64_t bytes() const {
    return nodes.size() * sizeof(BvhNode) + ids.size() * sizeof(std::uint32_t);
  }
};

/// Greatest depth of a leaf in any hierarchy: walks keep a stack of this size.
inline constexpr int kMaxBvhDepth = 96;

/// From this depth on lists are halved, by the order of their centers along the longest axis: with
/// fewer than 2^32 references no leaf comes to lie deeper than kMaxBvhDepth.
inline constexpr int kHalvingDepth = 64;

}  // namespace sightline::accel::published::bvh

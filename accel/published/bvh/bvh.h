// Storage of a bounding volume hierarchy: nodes with two children each, and the ids in its leaves.
// It is built whole, and immutable afterwards.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/geometry/aabb.h"

namespace sightline::accel::published::bvh {

/// A child of a node: an inner node or a leaf, with its box. It is an empty leaf by default.
struct BvhChild {
  geometry::Aabb box{};
  std::uint32_t first = 0;  ///< Inner: index of the node. Leaf: index of the first id.
  std::uint32_t count = 0;  ///< Ids in the leaf.
  bool inner = false;
};

/// An inner node. It holds its children's boxes, so that one cache line suffices to test both.
/// Equal faces of both boxes are stored side by side, for vector arithmetic.
struct alignas(64) BvhNode {
  static constexpr std::uint32_t kInner = 0xffffffffu;

  /// bounds[axis][child]: lower bounds; bounds[3 + axis][child]: upper bounds.
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

/// Nodes are in depth-first order, left children first; ids in the order of their leaves. A
/// triangle whose reference was split is in several leaves.
///
/// Every point of a triangle lies in the box of a leaf that has the triangle, and in all boxes
/// above that leaf.
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

/// Largest depth of a leaf in any hierarchy: traversals keep a stack of this size.
inline constexpr int kMaxBvhDepth = 96;

/// From this depth on lists are halved, in the order of their centers along the longest axis. With
/// fewer than 2^32 references no leaf is then deeper than kMaxBvhDepth.
inline constexpr int kHalvingDepth = 64;

}  // namespace sightline::accel::published::bvh

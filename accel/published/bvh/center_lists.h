// The references of a node in three lists, one per axis, in the order of their centers.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/grow/list_stack.h"
#include "accel/kdtree/reference.h"
#include "accel/published/bvh/lanes.h"

namespace sightline::accel::published::bvh {

/// A reference, or a part of one that was split: eight lanes, so that growing a box by it takes two
/// vector steps. The fourth lanes hold the bits of integers.
struct Fragment {
  Lanes lo, hi;

  Fragment() = default;
  /// `order` is the index of the reference in the list of the whole hierarchy, sorted by id. A node
  /// has at most one fragment of each reference.
  Fragment(const geometry::Aabb& box, std::uint32_t id, std::uint32_t order)
      : lo{box.lo.x, box.lo.y, box.lo.z, std::bit_cast<float>(id)},
        hi{box.hi.x, box.hi.y, box.hi.z, std::bit_cast<float>(order)} {}

  std::uint32_t id() const { return std::bit_cast<std::uint32_t>(lo[3]); }
  std::uint32_t order() const { return std::bit_cast<std::uint32_t>(hi[3]); }
  geometry::Aabb bounds() const { return LaneBox{lo, hi}.aabb(); }
  float center(std::size_t axis) const { return 0.5f * lo[axis] + 0.5f * hi[axis]; }
  Fragment with(const geometry::Aabb& box) const { return {box, id(), order()}; }
};

/// The order along an axis; a total order within a node.
inline bool precedes(const Fragment& a, const Fragment& b, std::size_t axis) {
  const float x = a.center(axis), y = b.center(axis);
  return x != y ? x < y : a.order() < b.order();
}

using FragmentStack = grow::ListStack<Fragment>;

struct CenterLists {
  std::array<std::span<Fragment>, 3> along;
  geometry::Aabb box;  ///< Bounds of all fragments.

  std::size_t size() const { return along[0].size(); }
};

inline geometry::Aabb box_around(std::span<const Fragment> fragments) {
  LaneBox box;
  for (const Fragment& f : fragments) box.grow(f.lo, f.hi);
  return box.aabb();
}

/// Makes sorted lists of all references, on the stack. Touches: a sort per axis.
CenterLists sort_by_centers(std::span<const kdtree::Reference> refs, FragmentStack& stack,
                            kdtree::BuildCounters& counters);

struct ListHalves {
  CenterLists left, right;
};

/// Divides lists into the first `left` fragments along `axis` and the others, in the memory of the
/// lists; the stack is scratch memory. Touches: a pass for the boxes and one per axis to divide.
ListHalves divide_by_centers(const CenterLists& lists, std::size_t axis, std::size_t left,
                             FragmentStack& stack, kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh

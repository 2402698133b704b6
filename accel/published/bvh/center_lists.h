// What a node holds, three times over: in the order of the centers along each axis.
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

/// A reference of which a part may have been split off: eight lanes, so that bounds take it in in
/// two steps. The fourth lanes hold the bits of numbers, not floats.
struct Fragment {
  Lanes lo, hi;

  Fragment() = default;
  /// `order`: its place in the list that the hierarchy is built over, ids ascending. A node holds
  /// one fragment of each at most.
  Fragment(const geometry::Aabb& box, std::uint32_t id, std::uint32_t order)
      : lo{box.lo.x, box.lo.y, box.lo.z, std::bit_cast<float>(id)},
        hi{box.hi.x, box.hi.y, box.hi.z, std::bit_cast<float>(order)} {}

  std::uint32_t id() const { return std::bit_cast<std::uint32_t>(lo[3]); }
  std::uint32_t order() const { return std::bit_cast<std::uint32_t>(hi[3]); }
  geometry::Aabb bounds() const { return LaneBox{lo, hi}.aabb(); }
  float center(std::size_t axis) const { return 0.5f * lo[axis] + 0.5f * hi[axis]; }
  Fragment with(const geometry::Aabb& box) const { return {box, id(), order()}; }
};

/// The order along an axis: total within a node.
inline bool precedes(const Fragment& a, const Fragment& b, std::size_t axis) {
  const float x = a.center(axis), y = b.center(axis);
  return x != y ? x < y : a.order() < b.order();
}

using FragmentStack = grow::ListStack<Fragment>;

struct CenterLists {
  std::array<std::span<Fragment>, 3> along;
  geometry::Aabb box;  ///< Around all of them.

  std::size_t size() const { return along[0].size(); }
};

inline geometry::Aabb box_around(std::span<const Fragment> fragments) {
  LaneBox box;
  for (const Fragment& f : fragments) box.grow(f.lo, f.hi);
  return box.aabb();
}

/// All references, on the stack. Touches: a sort an axis.
CenterLists sort_by_centers(std::span<const kdtree::Reference> refs, FragmentStack& stack,
                            kdtree::BuildCounters& counters);

struct ListHalves {
  CenterLists left, right;
};

/// The first `left` fragments along `axis` and the others, both where the lists were; the stack is
/// used meanwhile. Touches: a pass for the boxes and one an axis to divide.
ListHalves divide_by_centers(const CenterLists& lists, std::size_t axis, std::size_t left,
                             FragmentStack& stack, kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh

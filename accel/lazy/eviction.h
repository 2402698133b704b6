// What a tree can do without: pieces that go when the memory of the trees is short, and grow again
// where rays need them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "accel/geometry/aabb.h"
#include "accel/kdtree/kd_tree.h"
#include "accel/lazy/tree_context.h"

namespace sightline::accel::lazy {

/// Lists of fewer references are not worth a cell of their own.
inline constexpr std::size_t kFewestToEvict = 16;

/// A finished subtree, which becomes a deferred cell with a compact list; or the list of a deferred
/// cell, which becomes compact. What holds all of a mesh keeps no list at all.
struct Evictable {
  kdtree::AtomicSlot* slot = nullptr;
  geometry::Aabb cell;
  int depth = 0;
  std::uint64_t bytes = 0;  ///< About as many are freed.
  /// What building it again costs for each byte, by how long ago it was used. The least goes first.
  std::uint64_t value = 0;
};

/// The same cell with a compact list, or without a list if it holds all of a mesh. Throws
/// std::bad_alloc.
std::unique_ptr<kdtree::DeferredCell> with_compact_list(const TreeContext& context,
                                                        const kdtree::DeferredCell& cell);

}  // namespace sightline::accel::lazy

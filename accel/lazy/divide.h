// What a cell becomes when it is expanded: a leaf, a node over two to eight cells, or the same cell
// with a finer list.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "accel/kdtree/deferred_cell.h"
#include "accel/lazy/passes.h"
#include "accel/lazy/tree_context.h"

namespace sightline::accel::lazy {

/// What takes the place of a cell: the new cells, which become the children of a node. Where the
/// cell is not cut there is one, the same cell with a finer list, or none: the cell becomes a leaf.
struct Division {
  std::vector<std::unique_ptr<kdtree::DeferredCell>> cells{};
  std::vector<geometry::Aabb> boxes{};  ///< The bounds of what lies in each cell, if it is cut.
  bool is_cut = false;

  bool is_finer() const { return !is_cut && !cells.empty(); }
};

/// Divides a cell, by passes over its references in slices: at several planes found in a sample, if
/// the list is long and the rule takes samples; else at one. Cells above the weight `fill_above`
/// are then cut again, until a node is full. A list that is not in memory and is not cut by a
/// sample is made; references that stand for several are opened where no cut can be judged. Threads
/// that share the passes get equal divisions, whose lists they share. Throws std::bad_alloc, and
/// Cancelled.
Division divide(const TreeContext& context, const kdtree::DeferredCell& cell, Passes passes,
                std::uint64_t fill_above);

/// A cell with openable references and at most this many in total opens them before it is cut: the
/// cost of a plane is known better then, and a reference is no longer small compared with the cell.
inline constexpr std::size_t kOpenBelow = 2;

/// If one in kStraddlersToOpen references is openable and straddles the plane, the references are
/// opened first: their weight counts twice, so every cut looks bad.
inline constexpr std::size_t kStraddlersToOpen = 4;

}  // namespace sightline::accel::lazy

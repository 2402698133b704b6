// What a cell becomes when it is expanded: a leaf, a node over two to eight cells, or the same cell
// with a finer list.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/deferred_cell.h"
#include "accel/lazy/cell_task.h"
#include "accel/lazy/reference_source.h"
#include "accel/lazy/split_tree.h"
#include "accel/split/split_search.h"

namespace sightline::accel::lazy {

/// What every cell of a tree is expanded by. `mesh`: what the references are faces of, for builders
/// that clip; null if they are not.
struct DivideContext {
  const split::SplitRule& rule;
  const ReferenceSource& source;
  const geometry::MeshView* mesh;
  int max_depth;
};

/// The list of a cell that a division makes.
struct ChildList {
  kdtree::CellList list;
  kdtree::ChildScan first;
  bool openable = false;
};

/// A cell that a division makes, not stored yet.
struct NewCell {
  geometry::Aabb box;
  kdtree::CellPath path;
  ChildList part;
  std::uint64_t weight = 0;  ///< Of the references in its list.
};

/// What takes the place of a cell: the new cells, which become the children of a node. Where the
/// cell is not cut there is one, the same cell with a finer list, or none: the cell becomes a leaf.
struct Division {
  std::vector<NewCell> cells{};
  bool is_cut = false;
  bool compact = false;  ///< There is room for the ids of the new lists only.
};

/// The cell that waits. Throws std::bad_alloc.
std::unique_ptr<kdtree::DeferredCell> cell_of(NewCell now);

/// Divides a cell with a short list: in two, and in trees over instances into as many cells as a
/// node holds, since rays come to most of them. Throws std::bad_alloc.
Division divide_short(const DivideContext& context, const kdtree::DeferredCell& cell,
                      kdtree::BuildCounters& counters);

/// The same for a long list, or for a list that is not made yet (which gives a finer list). The
/// passes are shared by all threads that expand the cell. Each thread gets an equal division; its
/// lists are shared.
Division divide_long(const DivideContext& context, const kdtree::DeferredCell& cell,
                     PassSequence passes, kdtree::BuildCounters& counters);

/// The same where a sample of the list tells how: for builders that take samples, and at least
/// kSampleFrom references that cannot be opened. Nothing otherwise, or if the sample does not tell.
std::optional<Division> divide_sampled(const DivideContext& context,
                                       const kdtree::DeferredCell& cell, PassSequence& passes,
                                       kdtree::BuildCounters& counters);

/// The subtree of a deferred cell of at most this weight is built at once: dividing it cell by cell
/// would cost more work than it defers. In trees with leaf blocks that is grow::kBlockCell.
inline constexpr std::size_t kEagerBelow = 64;

/// A cell with openable references and at most this many in total opens them before it is cut: the
/// cost of a plane is known better then, and a reference is no longer small compared with the cell.
inline constexpr std::size_t kOpenBelow = 2;

/// If one in kStraddlersToOpen references is openable and straddles the plane, the references are
/// opened first: their weight counts twice, so every cut looks bad.
inline constexpr std::size_t kStraddlersToOpen = 4;

}  // namespace sightline::accel::lazy

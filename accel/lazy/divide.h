// What becomes of a cell that is expanded: a leaf, two cells, a few cells at once, or the same cell
// with a finer list.
#pragma once

#include <optional>

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

/// The list of one of the cells that come of a division.
struct Part {
  kdtree::CellList list;
  kdtree::FirstScan first;
  bool openable = false;
};

struct Division {
  enum class Kind { kLeaf, kCut, kCuts, kFiner };
  Kind kind = Kind::kLeaf;
  kdtree::Cut cut;                      ///< kCut.
  kdtree::CellPath path;                ///< kCut: the cell's, as the cut leaves it.
  Part left, right;                     ///< kCut; kFiner: `left` is the whole.
  std::shared_ptr<const CutTree> cuts;  ///< kCuts.
  std::vector<Part> parts;              ///< kCuts: cuts->parts().
};

/// Divides a cell with a short list. Throws std::bad_alloc.
Division divide_short(const DivideContext& context, const kdtree::DeferredCell& cell,
                      kdtree::BuildCounters& counters);

/// The same for a long list, or for one that is not made yet (which gives kFiner): in stages, with
/// whoever else is at it. Every thread that comes here gets an equal division, its lists shared.
Division divide_long(const DivideContext& context, const kdtree::DeferredCell& cell, Replay replay,
                     kdtree::BuildCounters& counters);

/// The same where a sample of the list tells how: for builders that take samples, and at least
/// kSampleFrom references that cannot be opened. Nothing otherwise, or if the sample does not tell.
std::optional<Division> divide_sampled(const DivideContext& context,
                                       const kdtree::DeferredCell& cell, Replay& replay,
                                       kdtree::BuildCounters& counters);

/// At so few references a cell that holds openable ones opens them before it is cut: what a plane
/// costs is known better then, and an entry is no longer small beside the cell.
inline constexpr std::size_t kOpenBelow = 2;

/// At so many openable references on both sides of a plane, one in kStraddlersToOpen, they are
/// opened first: their weight counts twice and every cut looks bad.
inline constexpr std::size_t kStraddlersToOpen = 4;

}  // namespace sightline::accel::lazy

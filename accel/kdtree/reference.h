// A reference: the weighted box of a primitive. Builders scan and sift lists of references.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>

#include "accel/geometry/aabb.h"

namespace sightline::accel::split {
struct PassResult;  // scan_pass.h
}  // namespace sightline::accel::split

namespace sightline::accel::kdtree {

/// Flag in the id of a reference that stands for several and can be opened into them: a run of
/// triangles, a group of nodes. Leaves hold no openable references.
inline constexpr std::uint32_t kOpenable = std::uint32_t{1} << 31;

/// The weighted box of a primitive in 32 bytes, read in order by every pass. bounds() went through
/// widen_flat.
struct Reference {
  geometry::Vec3f lo;
  std::uint32_t id = 0;  ///< A face or an instance, as in leaves; with kOpenable, several of them.
  geometry::Vec3f hi;
  std::uint32_t weight =
      1;  ///< Cost of testing it, in triangle tests. The weights of a list sum to less than 2^32.

  geometry::Aabb bounds() const { return {lo, hi}; }
  bool openable() const { return (id & kOpenable) != 0; }
};
static_assert(sizeof(Reference) == 32);

/// The union of the boxes of references; empty for none.
inline geometry::Aabb bounds_of(std::span<const Reference> refs) {
  geometry::Aabb box;
  for (const Reference& ref : refs) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.lo[axis] = std::min(box.lo[axis], ref.lo[axis]);
      box.hi[axis] = std::max(box.hi[axis], ref.hi[axis]);
    }
  }
  return box;
}

inline double total_weight(std::span<const Reference> refs) {
  std::uint64_t sum = 0;
  for (const Reference& ref : refs) sum += ref.weight;
  return static_cast<double>(sum);
}

/// Work done by build passes, in the units of docs/benchmarks.md.
struct BuildCounters {
  std::uint64_t touches = 0;          ///< References read, summed over passes.
  std::uint64_t touches_prepare = 0;  ///< Boxes computed from vertices.
  std::uint64_t cells_expanded = 0;   ///< Deferred cells that became inner nodes or leaves.
  std::uint64_t trees_begun = 0;      ///< Expanded cells that were roots.
  /// Time spent on expanding, summed over threads. It is for reports, never for decisions.
  double seconds = 0;

  BuildCounters& operator+=(const BuildCounters& o) {
    touches += o.touches;
    touches_prepare += o.touches_prepare;
    cells_expanded += o.cells_expanded;
    trees_begun += o.trees_begun;
    seconds += o.seconds;
    return *this;
  }
};

/// An axis-aligned plane: x[axis] = position.
struct Plane {
  int axis = 0;
  float position = 0;
  bool operator==(const Plane&) const = default;
};

/// A plane, and the side of the boxes that lie flat in it. By the rule of membership (is_member)
/// that is the right side; builders that follow Wald and Havran choose it.
struct Split {
  Plane plane;
  bool planar_left = false;
  bool at_a_loss = false;  ///< A leaf would be cheaper; made because splits below may be better.
  bool operator==(const Split&) const = default;
};

/// Whether a box is flat along an axis: it has the least extent that widen_flat gives.
inline bool is_planar(const Reference& ref, std::size_t axis) {
  return ref.hi[axis] == geometry::least_above(ref.lo[axis]);
}

/// What a cell inherits from the cells above it.
struct CellPath {
  int depth = 0;           ///< Depth of the cell; 0 at the root.
  int cuts_at_a_loss = 0;  ///< Splits above the cell that were made at a loss (Split::at_a_loss).
  /// References that splits of this cell and below may add (reference_budget.h).
  double references_left = std::numeric_limits<double>::infinity();
  /// References that the lists of this cell's children may hold together, beside those that wait in
  /// the lists of the siblings above (reference_budget.h).
  double list_capacity = std::numeric_limits<double>::infinity();
  /// Duplication factor: how many references one root reference has become along this path. The
  /// product, over the splits above, of the references after over those before. Kept only if
  /// references_left is finite.
  double duplication = 1;

  CellPath below(const Split& cut) const {
    CellPath below = *this;
    below.depth = depth + 1;
    below.cuts_at_a_loss += cut.at_a_loss ? 1 : 0;
    return below;
  }
  bool operator==(const CellPath&) const = default;
};

struct ChildScan;  // plane_counts.h

/// A cell, as a split rule is asked about it.
struct CellRefs {
  std::span<const Reference> refs;  ///< Members of the cell; their boxes may reach beyond it.
  geometry::Aabb box;
  CellPath path;
  std::size_t size = refs.size();  ///< Number of members.
  /// Runs a pass over a list that is not in one piece (RunPass, scan_pass.h); `refs` may then be
  /// empty. It is set only for rules with SplitSearch::runs_passes, and for lists longer than
  /// kMaxBoundScan. Equal lists get equal passes in the same order.
  const std::function<split::PassResult(
      const std::function<split::PassResult(std::span<const Reference>)>&)>* run = nullptr;
  /// The counts of the first pass over the list, if known (plane_counts.h).
  const ChildScan* first = nullptr;
};

}  // namespace sightline::accel::kdtree

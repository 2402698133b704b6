// A reference as the builder sees it: a weighted box. Lists of them are what is scanned and sifted.
#pragma once

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

/// Set in the id of a reference that stands for several and can be opened into them: a run of
/// triangles, a group of nodes. Leaves hold none of those.
inline constexpr std::uint32_t kOpenable = std::uint32_t{1} << 31;

/// 32 bytes, read in order by every pass. `bounds` went through widen_flat.
struct BoxRef {
  geometry::Vec3f lo;
  std::uint32_t id = 0;  ///< What the leaf will hold: a face or an instance. Or see kOpenable.
  geometry::Vec3f hi;
  std::uint32_t weight =
      1;  ///< Cost of testing it, in triangle tests. A list's weights sum below 2^32.

  geometry::Aabb bounds() const { return {lo, hi}; }
  bool openable() const { return (id & kOpenable) != 0; }
};
static_assert(sizeof(BoxRef) == 32);

inline double total_weight(std::span<const BoxRef> refs) {
  std::uint64_t sum = 0;
  for (const BoxRef& ref : refs) sum += ref.weight;
  return static_cast<double>(sum);
}

/// Work done by build passes, in the units of docs/benchmarks.md.
struct BuildCounters {
  std::uint64_t touches = 0;          ///< One reference's bounds read by one pass.
  std::uint64_t touches_prepare = 0;  ///< One box made from vertices.
  std::uint64_t cells_expanded = 0;   ///< Deferred cells that became inner nodes or leaves.
  double seconds = 0;  ///< Spent expanding, summed over threads. For reports, never for decisions.

  BuildCounters& operator+=(const BuildCounters& o) {
    touches += o.touches;
    touches_prepare += o.touches_prepare;
    cells_expanded += o.cells_expanded;
    seconds += o.seconds;
    return *this;
  }
};

/// A place to cut a cell: x[axis] = position.
struct Plane {
  int axis = 0;
  float position = 0;
  bool operator==(const Plane&) const = default;
};

/// A plane, and on which side of it the boxes go that lie flat in it. By the rule of membership
/// (is_member) that is the right; builders that follow Wald and Havran choose.
struct Cut {
  Plane plane;
  bool planar_left = false;
  bool at_a_loss = false;  ///< A leaf would be cheaper: cut in the hope of better cuts below.
  bool operator==(const Cut&) const = default;
};

/// Whether a box lies flat in a plane, at ref.lo: widen_flat gave it the least extent there is.
inline bool is_planar(const BoxRef& ref, std::size_t axis) {
  return ref.hi[axis] == geometry::least_above(ref.lo[axis]);
}

/// What a cell inherits from the cells above it.
struct CellPath {
  int depth = 0;           ///< Of the root: 0.
  int cuts_at_a_loss = 0;  ///< How many of the cuts above it were (Cut::at_a_loss).
  /// How many references the cuts of this cell and below may add (reference_budget.h).
  double spare = std::numeric_limits<double>::infinity();
  /// How many references of this cell one reference of the root has become: the product, over the
  /// cuts above, of the references after the cut over those before it. Kept only where spare is
  /// finite.
  double swell = 1;

  CellPath below(const Cut& cut) const {
    return {depth + 1, cuts_at_a_loss + (cut.at_a_loss ? 1 : 0), spare, swell};
  }
  bool operator==(const CellPath&) const = default;
};

struct FirstScan;  // first_scan.h

/// A cell as a builder is asked about it.
struct CellRefs {
  std::span<const BoxRef> refs;  ///< Members of the cell; they may reach beyond it.
  geometry::Aabb box;
  CellPath path;
  std::size_t size = refs.size();  ///< How many members there are.
  /// Runs a pass over the list (RunPass, list_pass.h) where it is not at hand: `refs` may then be
  /// empty. For builders that `runs_passes`, and lists longer than kMaxBoundScan. Equal lists get
  /// equal passes in the same order.
  const std::function<split::PassResult(
      const std::function<split::PassResult(std::span<const BoxRef>)>&)>* run = nullptr;
  /// What the first pass over the list would find, where that is known (first_scan.h).
  const FirstScan* first = nullptr;
};

}  // namespace sightline::accel::kdtree

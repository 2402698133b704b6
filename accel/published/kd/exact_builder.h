// The exact surface area heuristic: the cheapest of all planes through the ends of boxes, looked
// for in three ways that find the same one. Source: Wald, Havran 2006, "On building fast kd-Trees
// for Ray Tracing, and on doing that in O(N log N)".
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "accel/published/kd/candidate.h"

namespace sightline::accel::kdtree {
class Slot;
}
namespace sightline::accel::grow {
struct GrowContext;
}

namespace sightline::accel::published::kd {

enum class ExactSearch : std::uint8_t {
  kNaive,  ///< Counts the whole list for every candidate: O(N^2) (section 4.1).
  kSort,   ///< Sorts the ends of the list and sweeps over them: O(N log^2 N) (section 4.2).
  kSweep,  ///< Sorts once for a whole subtree and keeps the order: O(N log N) (section 4.3).
};

/// A builder is a value: parameters, `check()`, and one decision.
struct ExactBuilder {
  ExactSearch search = ExactSearch::kSweep;
  ExactCosts costs{};
  /// How often on the way from the root to a leaf a cell of at least two references may be cut
  /// though no cut pays (section 3.3). Range 0 to 16.
  std::uint32_t bad_refines = 0;
  /// Perfect splits (section 3.4): straddlers shrink to the part of their triangle in the child.
  bool clip = true;

  bool operator==(const ExactBuilder&) const = default;

  /// Which parameter is out of range, and the range; nothing if all are fine.
  std::optional<std::string> check() const;

  /// The best candidate, unless testing every box is cheaper (and bad refines are used up) or
  /// nothing can be separated. Boxes that lie in the plane are tried on both sides of it
  /// (section 3.5); a plane may lie in the cell's own face if that moves such boxes into a flat
  /// cell. Sweeping is for whole subtrees: for one cell it sorts.
  ///
  /// Touches: naive, the list for every candidate; sort, an axis: the list, the sort, and the list
  /// for the sweep. Threads: any.
  std::optional<kdtree::Split> choose(const kdtree::CellRefs& cell,
                                      kdtree::BuildCounters& counters) const;

  bool clips() const { return clip; }

  /// Sweep only: the subtree under a cell from one sorted list of events; nothing for other
  /// searches, or if there are more references than events can name. As `grow` of grow.h otherwise.
  std::optional<kdtree::Slot> grow_subtree(const grow::GrowContext& context,
                                           std::span<const kdtree::Reference> refs,
                                           const geometry::Aabb& cell, const kdtree::CellPath& path,
                                           kdtree::BuildCounters& counters) const;

  /// The cut to make in a cell of this weight, given its best candidate.
  std::optional<kdtree::Split> decide(const Candidate& best, std::uint32_t weight,
                                      std::size_t references, const kdtree::CellPath& path) const;
};

}  // namespace sightline::accel::published::kd

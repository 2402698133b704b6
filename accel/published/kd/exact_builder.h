// The exact surface area heuristic: the cheapest of all planes through bounds of boxes. Three
// searches find the same plane. Source: Wald, Havran 2006, "On building fast kd-Trees for Ray
// Tracing, and on doing that in O(N log N)".
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "accel/published/kd/candidate.h"

namespace sightline::accel::published::kd {

enum class ExactSearch : std::uint8_t {
  kNaive,  ///< Scans the whole list for every candidate: O(N^2) (section 4.1).
  kSort,   ///< Sorts the ends of boxes in every cell and sweeps over them: O(N log^2 N)
           ///< (section 4.2).
  kSweep,  ///< Sorts once for a whole tree and keeps the order: O(N log N) (section 4.3).
};

/// A builder as a value: parameters, `check()`, and `choose()`.
struct ExactBuilder {
  ExactSearch search = ExactSearch::kSweep;
  ExactCosts costs{};
  /// Number of splits at a loss on a path from the root to a leaf, of cells of at least two
  /// references (section 3.3). Range 0 to 16.
  std::uint32_t bad_refines = 0;
  /// Perfect splits (section 3.4): the box of a straddler shrinks to the part of its triangle in
  /// the child.
  bool clip = true;

  bool operator==(const ExactBuilder&) const = default;

  /// A message that names a parameter out of range, and its range; nothing if all are in range.
  std::optional<std::string> check() const;

  /// Returns the best candidate; nothing if a leaf is cheaper (and bad refines are used up) or
  /// nothing can be separated. Boxes that lie in the plane are tried on both sides of it (section
  /// 3.5). A plane may lie in a face of the cell if that moves such boxes into a flat cell. kSweep
  /// works on whole trees (event_growth.h); for a single cell it sorts.
  ///
  /// Touches: kNaive: a pass for every candidate. Else, per axis: a pass to make events, the sort,
  /// and a pass to sweep. Threads: any.
  std::optional<kdtree::Split> choose(const kdtree::CellRefs& cell,
                                      kdtree::BuildCounters& counters) const;

  bool clips() const { return clip; }

  /// Returns the split to make in a cell of this weight, given its best candidate; nothing for a
  /// leaf.
  std::optional<kdtree::Split> decide(const Candidate& best, std::uint32_t weight,
                                      std::size_t references, const kdtree::CellPath& path) const;
};

}  // namespace sightline::accel::published::kd

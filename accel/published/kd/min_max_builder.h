// Min-max binning: the heuristic at the boundaries of a few bins, counted from a sample of the
// list. Source: Shevtsov, Soupikov, Kapustin 2007, "Highly Parallel Fast KD-tree Construction for
// Interactive Ray Tracing of Dynamic Scenes", as the survey's section 7 gives it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "accel/split/cost_model.h"
#include "accel/split/exhaustive_split.h"

namespace sightline::accel::published::kd {

/// A builder is a value: parameters, `check()`, and one decision.
struct MinMaxBuilder {
  /// Bins an axis, over the bounds of what the cell holds. Up to as many references every bound is
  /// a candidate instead. Range 2 to 256.
  std::uint32_t bins = 32;
  /// Bin only one in every l = log10(N) references of a cell of N.
  bool subsample = true;
  /// For how many threads T the tree is decomposed first: the top log2 T levels are cut at the
  /// boundary, of 512 T bins along the longest axis, that lies nearest the median. 0: as many as
  /// the arena has; 1: no decomposition. Range 0 to 1024.
  std::uint32_t threads = 0;
  split::SahConstants cost{.traverse = 1, .intersect = 1.5, .empty_bonus = 1};

  static constexpr std::uint32_t kMaxBins = 256;
  static constexpr std::uint32_t kDecompositionBins = 512;

  bool operator==(const MinMaxBuilder&) const = default;

  /// Which parameter is out of range, and the range; nothing if all are fine.
  std::optional<std::string> check() const;

  /// Touches: one pass for the bounds of the contents, one over the sample; at the bottom, an axis,
  /// one for every kScanWidth candidates. Threads: any. Long lists are counted in parallel in the
  /// caller's arena.
  std::optional<kdtree::Split> choose(const kdtree::CellRefs& cell,
                                      kdtree::BuildCounters& counters) const;

  /// Boxes are left as they are: a straddler keeps its bounds on both sides.
  bool clips() const { return false; }

  /// How lists of this length are cut, if every bound is a candidate.
  std::optional<split::BoundRule> bound_rule(std::size_t references) const {
    if (references > bins) return std::nullopt;
    return split::BoundRule{.cost = cost};
  }

 private:
  /// Threads of the decomposition that share a cell at this depth.
  std::uint32_t threads_at(int depth) const;
  /// The best boundary of the bins.
  std::optional<kdtree::Split> choose_boundary(std::span<const kdtree::Reference> refs,
                                               const geometry::Aabb& cell,
                                               kdtree::BuildCounters& counters) const;
};

}  // namespace sightline::accel::published::kd

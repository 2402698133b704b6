// Min-max binning: the SAH at the boundaries of a few bins, counted from a sample of the list.
// Source: Shevtsov, Soupikov, Kapustin 2007, "Highly Parallel Fast KD-tree Construction for
// Interactive Ray Tracing of Dynamic Scenes", as the survey's section 7 gives it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "accel/split/cost_model.h"
#include "accel/split/exhaustive_split.h"

namespace sightline::accel::published::kd {

/// A builder as a value: parameters, `check()`, and `choose()`.
struct MinMaxBuilder {
  /// Bins per axis, over the bounds of the cell's contents. Lists of at most this length try every
  /// bound instead. Range 2 to 256.
  std::uint32_t bins = 32;
  /// Whether only one in l = log10(N) references of a cell of N is counted.
  bool subsample = true;
  /// Number of threads T of the initial decomposition: the top log2 T levels are split at the
  /// boundary nearest the median, of kDecompositionBins T bins along the longest axis. 0: the
  /// arena's threads; 1: no decomposition. Range 0 to 1024.
  std::uint32_t threads = 0;
  split::SahConstants cost{.traverse = 1, .intersect = 1.5, .empty_bonus = 1};

  static constexpr std::uint32_t kMaxBins = 256;
  static constexpr std::uint32_t kDecompositionBins = 512;

  bool operator==(const MinMaxBuilder&) const = default;

  /// A message that names a parameter out of range, and its range; nothing if all are in range.
  std::optional<std::string> check() const;

  /// Touches: one pass for the bounds of the contents, one over the sample; for short lists, per
  /// axis, one for every kScanWidth candidates. Threads: any. Long lists are counted in parallel in
  /// the caller's arena.
  std::optional<kdtree::Split> choose(const kdtree::CellRefs& cell,
                                      kdtree::BuildCounters& counters) const;

  /// Straddlers are never clipped: they keep their bounds on both sides.
  bool clips() const { return false; }

  /// The rule for lists of this length, if every bound is a candidate.
  std::optional<split::BoundRule> bound_rule(std::size_t references) const {
    if (references > bins) return std::nullopt;
    return split::BoundRule{.cost = cost};
  }

 private:
  /// Threads of the decomposition for one cell at this depth.
  std::uint32_t threads_at(int depth) const;
  /// The split at the best boundary of the bins.
  std::optional<kdtree::Split> choose_boundary(std::span<const kdtree::Reference> refs,
                                               const geometry::Aabb& cell,
                                               kdtree::BuildCounters& counters) const;
};

}  // namespace sightline::accel::published::kd

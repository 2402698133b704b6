// The product's split rule: an adaptive scan over all axes, with exhaustive search for short lists.
// The passes are those of Hunt, Mark, Stoll 2006; the choice of planes is ours (guided_scan.h).
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "accel/split/cost_model.h"
#include "accel/split/exhaustive_split.h"
#include "accel/split/split_search.h"

namespace sightline::accel::split {

/// Most references for each triangle in a plain tree. Good trees over compact meshes have four to
/// eight.
inline constexpr double kPlainBudget = 16;
/// Most references for each triangle above leaf blocks. A larger budget makes trees larger, and
/// slower for architecture; slivers are traced faster (docs/decisions/trees.md, Leaf blocks).
inline constexpr double kBlockBudget = 1.3;
/// Stands for kBlockBudget where leaves are blocks, else for kPlainBudget.
inline constexpr double kUsualBudget = -1;

/// The rule as a value: its parameters, `check()`, and `choose()`.
struct ScanSplit {
  /// Sample planes an axis in the first pass, the cell's faces included. Range 2 to
  /// kdtree::kUniformPlanes.
  std::uint32_t uniform_samples = 8;
  /// Lists up to this length are split at the best of their bounds. For longer lists two passes
  /// cost fewer touches and no more time. Range 0 to kMaxBoundScan.
  std::uint32_t exact_below = 48;
  /// Lists split at their bounds try all axes up to this length, and only the longest axis beyond
  /// it.
  std::uint32_t all_axes_up_to = 8;
  /// If the longest axis has no bound below this share of the leaf's cost, the other two axes are
  /// tried, too. Range from 1e-6; infinite: never.
  double retry_above = std::numeric_limits<double>::infinity();
  /// Whether the second pass scans all axes, not only the one with the best estimate.
  bool refine_all_axes = true;
  /// Whether splits are perfect: the box of a straddler shrinks to the part of its triangle in the
  /// child (grow/clip_straddlers.h).
  bool clip = false;
  /// Whether splits are perfect in lists with a high straddle ratio (kStraddleShare): their
  /// triangles are long compared with the cells, and boxes are a poor bound.
  bool clip_dense = false;
  /// Limit on references per triangle in the tree, or above its leaf blocks; each subtree gets a
  /// share of it (reference_budget.h). 0: no limit in plain trees, the usual one above blocks.
  /// Range kUsualBudget, 0, 1 to 64.
  double budget = kUsualBudget;
  SahConstants cost{};

  bool operator==(const ScanSplit&) const = default;

  /// A message that names a parameter out of range, and its range; nothing if all are in range.
  std::optional<std::string> check() const;

  /// Returns the cheapest plane found strictly inside the cell; nothing if no split is cheaper than
  /// a leaf, or no plane lies inside. Threads: any.
  std::optional<kdtree::Split> choose(const kdtree::CellRefs& cell,
                                      kdtree::BuildCounters& counters) const;

  /// See SplitSearch::clips.
  bool clips(std::size_t straddlers, std::size_t references) const;

  /// The rule for lists of this length, if they are searched exhaustively.
  std::optional<BoundRule> bound_rule(std::size_t references) const;
};

/// Whether a cell holds long triangles: cuts above it have multiplied its references far more than
/// those of a surface. About sqrt(n) of n triangles of a surface cross the border of a cell, so
/// duplication - 1 is a few times sqrt(1 / n) there.
bool is_over_duplicated(const kdtree::CellPath& path, std::size_t references);

/// The default: fast to build.
ScanSplit scan_fast();

/// The best trees: all axes at the bottom, every straddler clipped.
ScanSplit scan_best();

/// The rule behind the SplitSearch interface.
SplitRule make_rule(const ScanSplit& rule);

}  // namespace sightline::accel::split

// Where the product cuts cells: an adaptive scan over all axes, with exact search at the bottom.
// The passes are those of Hunt, Mark, Stoll 2006; what guides them is ours (guided_scan.h).
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "accel/split/cost_model.h"
#include "accel/split/split_search.h"

namespace sightline::accel::split {

/// A builder is a value: parameters, `check()`, and one decision.
struct ScanSplit {
  /// Sample planes an axis in the first pass, the cell's faces included. Range 2 to
  /// kdtree::kFirstPlanes.
  std::uint32_t uniform_samples = 8;
  /// Lists up to this length are cut at the best of their bounds. Longer ones cost fewer touches
  /// and no more time by two passes. Range 0 to kMaxBoundScan.
  std::uint32_t exact_below = 48;
  /// Lists up to this length that are cut at their bounds try all axes, longer ones the longest.
  std::uint32_t all_axes_up_to = 8;
  /// Where the longest axis offers no bound below this share of the leaf's cost, the other two are
  /// tried as well. Range from 1e-6; infinite: never.
  double retry_above = std::numeric_limits<double>::infinity();
  /// The second pass looks at all axes, not at the most promising alone.
  bool refine_all_axes = true;
  /// Perfect splits: straddlers shrink to the part of their triangle in the child
  /// (grow/clip_straddlers.h).
  bool clip = false;
  /// The same, but only where one in four references of a list straddles (kCrowd): triangles that
  /// are long against their cells, so that their boxes say little.
  bool clip_crowds = false;
  /// References a triangle that cuts may reach; where that is too few, each subtree gets its share
  /// (grow/reference_budget.h). Good trees over compact meshes have four to eight. 0: no limit.
  /// Range 0, 1 to 64.
  double budget = 16;
  SahConstants cost{};

  bool operator==(const ScanSplit&) const = default;

  /// Which parameter is out of range, and the range; nothing if all are fine.
  std::optional<std::string> check() const;

  /// The cheapest plane found strictly inside the cell, or nothing if no cut is cheaper than
  /// testing every box, or no plane fits. Threads: any.
  std::optional<kdtree::Cut> choose(const kdtree::CellRefs& cell,
                                    kdtree::BuildCounters& counters) const;

  /// See SplitSearch::clips.
  bool clips(std::size_t straddlers, std::size_t references) const;

  /// How lists of this length are cut, if every bound is a candidate.
  std::optional<BoundRule> bound_rule(std::size_t references) const;
};

/// The default: fast to build.
ScanSplit scan_fast();

/// The best trees: all axes at the bottom, every straddler clipped.
ScanSplit scan_best();

/// The interface to that rule.
SplitRule make_rule(const ScanSplit& rule);

/// scan_fast(), made once.
const SplitRule& default_rule();

}  // namespace sightline::accel::split

// Hunt's adaptive scan: where to cut a cell, found by a few passes over its list and no sorting.
// Source: Hunt, Mark, Stoll 2006, "Fast kd-tree Construction with an Adaptive Error-Bounded
// Heuristic".
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "accel/split/child_scan.h"
#include "accel/split/cost_model.h"
#include "accel/split/exhaustive_split.h"

namespace sightline::accel::published::kd {

enum class ScanAxes : std::uint8_t {
  kOne,     ///< The cell's longest axis (paper: "one axis").
  kHybrid,  ///< All axes up to hybrid_below boxes, above that the longest.
  kAll,
};

/// A builder is a value: parameters, `check()`, and one decision.
struct HuntScan {
  ScanAxes axes = ScanAxes::kAll;
  /// Sample planes an axis in the first, uniform stage, the cell's faces included: a pass for every
  /// kUniformPlanes. Range 2 to kMostSamples.
  std::uint32_t uniform_samples = 8;
  /// Sample planes an axis in the second stage, placed along the range of C_L - C_R: as many
  /// passes. Range 0 to kMostSamples.
  std::uint32_t adaptive_samples = 8;
  /// Up to this many boxes every bound is a candidate: below where that costs more time than two
  /// sampling passes. The paper has 36 by the same rule. Range 0 to kMaxExact.
  std::uint32_t exact_below = 96;
  /// See ScanAxes::kHybrid.
  std::uint32_t hybrid_below = 1024;
  split::SahConstants cost{};

  // Ours, not the paper's; off by default.

  /// Where the longest axis alone offers no cut below this share of the leaf's cost, the other two
  /// are tried as well. Range from 1e-6; infinite: never.
  double retry_above = std::numeric_limits<double>::infinity();
  /// Move a sampled plane to the cheaper of the two box bounds next to it: between bounds the cost
  /// is linear, so the minimum always lies at one. Costs two passes.
  bool snap = false;
  /// Perfect splits: see clip_straddlers.
  bool clip = false;

  static constexpr std::uint32_t kMaxExact = split::kMaxBoundScan;

  bool operator==(const HuntScan&) const = default;

  /// Which parameter is out of range, and the range; nothing if all are fine.
  std::optional<std::string> check() const;

  /// The cheapest plane strictly inside the cell, or nothing if no cut is cheaper than testing
  /// every box, or no plane fits. Threads: any. Large lists are scanned in parallel in the caller's
  /// arena; the answer does not depend on how.
  std::optional<kdtree::Split> choose(const kdtree::CellRefs& cell,
                                      kdtree::BuildCounters& counters) const;

  /// Whether lists that come of sifting one of `references` boxes are worth counting meanwhile
  /// (CellRefs::first). Not for short ones, most of whose children are cut by their bounds, and not
  /// with clipping, which changes what was counted.
  bool scans_children(std::size_t references) const {
    return !clip && uniform_samples <= kdtree::kUniformPlanes &&
           references >= 2 * std::size_t{exact_below};
  }

  /// How lists of this length are cut, if every bound is a candidate.
  std::optional<split::BoundRule> bound_rule(std::size_t references) const;
};

}  // namespace sightline::accel::published::kd

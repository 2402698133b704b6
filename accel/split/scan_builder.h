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

#include "accel/result.h"
#include "accel/split/child_scan.h"
#include "accel/split/cost_model.h"
#include "accel/split/exhaustive_split.h"

namespace sightline::accel::split {

enum class ScanAxes : std::uint8_t {
  kOne,     ///< The cell's longest axis (paper: "one axis").
  kHybrid,  ///< All axes up to hybrid_below boxes, above that the longest.
  kAll,
  kGuided,  ///< All in the first pass, those that it makes promising in the second: choose_guided.
};

/// A builder is a value: parameters, `check()`, and one decision.
struct ScanBuilder {
  ScanAxes axes = ScanAxes::kAll;
  /// Sample planes an axis in the first, uniform stage, the cell's faces included: a pass for every
  /// kFirstPlanes. Range 2 to kMostSamples, for kGuided to kFirstPlanes.
  std::uint32_t uniform_samples = 8;
  /// Sample planes an axis in the second stage, placed along the range of C_L - C_R: as many
  /// passes. Range 0 to kMostSamples. kGuided has none.
  std::uint32_t adaptive_samples = 8;
  /// Up to this many boxes every bound is a candidate: below where that costs more time than two
  /// sampling passes. The paper has 36 by the same rule. Range 0 to kMaxExact.
  std::uint32_t exact_below = 96;
  /// See ScanAxes::kHybrid. For kGuided: up to this many boxes, where every bound is a candidate,
  /// all axes are tried.
  std::uint32_t hybrid_below = 1024;
  SahConstants cost{};

  // Ours, not the paper's; off unless a builder's name says otherwise.

  /// Where the longest axis alone offers no cut below this share of the leaf's cost, the other two
  /// are tried as well. For kGuided: where every bound is a candidate. Range from 1e-6; infinite:
  /// never.
  double retry_above = std::numeric_limits<double>::infinity();
  /// Move a sampled plane to the cheaper of the two box bounds next to it: between bounds the cost
  /// is linear, so the minimum always lies at one. Costs two passes.
  bool snap = false;
  /// ScanAxes::kGuided: the second pass looks at all axes, not at the most promising alone.
  bool refine_all_axes = false;
  /// Perfect splits: see clip_straddlers.
  bool clip = false;
  /// The same, but where one in kCrowd references of a list straddles alone: triangles that are
  /// long against their cells, so that their boxes say little.
  bool clip_crowds = false;
  /// Cuts come to about so many references a triangle at most; where that is too few, each subtree
  /// gets its share (reference_budget.h). 0: as many as there is room for. Range 0, 1 to 64.
  double budget = 0;

  static constexpr std::uint32_t kMaxExact = kMaxBoundScan;
  /// Lists of so many references are never clipped as crowds.
  static constexpr std::size_t kCrowdBelow = 8192;

  bool operator==(const ScanBuilder&) const = default;

  /// Which parameter is out of range, and the range; nothing if all are fine.
  std::optional<std::string> check() const;

  /// The cheapest plane strictly inside the cell, or nothing if no cut is cheaper than testing
  /// every box, or no plane fits. Threads: any. Large lists are scanned in parallel in the caller's
  /// arena; the answer does not depend on how.
  std::optional<kdtree::Cut> choose(const kdtree::CellRefs& cell,
                                    kdtree::BuildCounters& counters) const;

  bool clips() const { return clip; }
  bool clips(const kdtree::CellPath& path, std::size_t straddlers, std::size_t references) const {
    return clip || (clip_crowds && is_crowd(path, straddlers, references));
  }

  /// Whether lists that come of sifting one of so many boxes are worth counting meanwhile
  /// (CellRefs::first): few that are not cut by their bounds come of short ones, and clipping
  /// changes what was counted.
  bool scans_children(std::size_t references) const {
    return !clip && uniform_samples <= kFirstPlanes && references >= 2 * std::size_t{exact_below};
  }
  /// Where the first pass over a child's list counts.
  FirstPlanes first_planes(const geometry::Aabb& child) const {
    return accel::split::first_planes(child, uniform_samples);
  }

  /// Whether long lists may be cut where a sample of them would be.
  bool takes_samples() const { return axes == ScanAxes::kGuided && !clip; }

  /// How lists of this length are cut, if every bound is a candidate.
  std::optional<BoundRule> bound_rule(std::size_t references) const;

 private:
  static bool is_crowd(const kdtree::CellPath& path, std::size_t straddlers,
                       std::size_t references);
};

}  // namespace sightline::accel::split

// Hunt's adaptive scan: finds a split by a few passes over the list, without sorting.
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
  kOne,     ///< The longest axis of the cell (paper: "one axis").
  kHybrid,  ///< All axes up to hybrid_below references, above that the longest.
  kAll,
};

/// A builder as a value: parameters, `check()`, and `choose()`.
struct HuntScan {
  ScanAxes axes = ScanAxes::kAll;
  /// Sample planes per axis in the first, uniform stage, including the cell's faces. Every
  /// kUniformPlanes planes take a pass. Range 2 to kMostSamples.
  std::uint32_t uniform_samples = 8;
  /// Sample planes per axis in the second stage, spread over the range of C_L - C_R; as many
  /// passes. Range 0 to kMostSamples.
  std::uint32_t adaptive_samples = 8;
  /// Lists up to this length try every bound, as long as that costs less time than two sampling
  /// passes. The paper has 36 by the same rule. Range 0 to kMaxExact.
  std::uint32_t exact_below = 96;
  /// See ScanAxes::kHybrid.
  std::uint32_t hybrid_below = 1024;
  split::SahConstants cost{};

  // The following are ours, not the paper's, and off by default.

  /// If the longest axis has no split below this share of the leaf's cost, the other two axes are
  /// tried, too. Range from 1e-6; infinite: never.
  double retry_above = std::numeric_limits<double>::infinity();
  /// Whether a sampled plane is snapped to the cheaper of the two bounds next to it. Between bounds
  /// the cost is linear, so a minimum is always at a bound. This costs two passes.
  bool snap = false;
  /// Whether straddlers are clipped (perfect splits): see clip_straddlers.
  bool clip = false;

  static constexpr std::uint32_t kMaxExact = split::kMaxBoundScan;

  bool operator==(const HuntScan&) const = default;

  /// A message that names a parameter out of range, and its range; nothing if all are in range.
  std::optional<std::string> check() const;

  /// Returns the cheapest plane strictly inside the cell; nothing if no split is cheaper than a
  /// leaf, or no plane lies inside. Threads: any. Long lists are scanned in parallel in the
  /// caller's arena; the result does not depend on the number of threads.
  std::optional<kdtree::Split> choose(const kdtree::CellRefs& cell,
                                      kdtree::BuildCounters& counters) const;

  bool clips() const { return clip; }

  /// Whether sifting a list of `references` also counts the first passes of the children
  /// (CellRefs::first). It does not for short lists, most of whose children try every bound, nor
  /// with clipping, which changes the counted boxes.
  bool scans_children(std::size_t references) const {
    return !clip && uniform_samples <= kdtree::kUniformPlanes &&
           references >= 2 * std::size_t{exact_below};
  }

  /// The rule for lists of this length, if every bound is a candidate.
  std::optional<split::BoundRule> bound_rule(std::size_t references) const;
};

}  // namespace sightline::accel::published::kd

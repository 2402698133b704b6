// Differences between a peer's answers and ours, and whether rounding explains them.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "accel/geometry/ray.h"
#include "scenegraph/revision/snapshot.h"

namespace sightline::bench {

struct Disagreement {
  std::uint64_t differences = 0;  ///< Rays whose (hit or miss, node, primitive) differ.
  std::uint64_t checked = 0;      ///< Evenly spread differences that are checked with the oracle.
  /// Checked differences that neither a tie, nor an edge, nor an end of the ray within 1e-5
  /// explains.
  std::uint64_t unexplained = 0;
};

/// Assumes that our answers are right (other checks cover them). For `any`, compares hit or miss
/// only.
Disagreement explain(std::shared_ptr<const scenegraph::revision::Snapshot> snapshot,
                     std::span<const accel::geometry::Ray> rays,
                     std::span<const accel::geometry::Hit> ours,
                     std::span<const accel::geometry::Hit> theirs, bool any);

}  // namespace sightline::bench

// A split from one uniform pass over all three axes, and from a second pass where the first shows
// that it can pay. The method is ours; the passes are those of Hunt, Mark, Stoll 2006, section 6.1.
#pragma once

#include <cstdint>
#include <optional>

#include "accel/kdtree/reference.h"
#include "accel/split/cost_model.h"

namespace sightline::accel::split {

/// Parameters of the guided scan.
struct GuidedRule {
  SahConstants cost;
  /// Planes an axis in the first pass, the cell's faces included. Range 2 to
  /// kdtree::kUniformPlanes.
  std::uint32_t uniform_samples = 8;
  /// Whether the second pass scans all axes; else the one with the best estimate.
  bool refine_all_axes = false;
  bool once = false;  ///< Whether there is no second pass.
};

/// Returns the cheapest plane found, if it is cheaper than a leaf. It takes two passes; one less if
/// the first is known (CellRefs::first), and one less if the second cannot find a better plane.
///
/// C_L only rises and C_R only falls along an axis, so the counts at the ends of a segment between
/// two planes bound the cost within it. The second pass scans kScanWidth planes an axis, spread
/// over the segments that may beat the best plane known. Each plane is then snapped to the next
/// bound on its cheaper side, without another pass: between bounds the cost is linear.
std::optional<kdtree::Split> choose_guided(const kdtree::CellRefs& list, const GuidedRule& rule,
                                           kdtree::BuildCounters& counters);

}  // namespace sightline::accel::split

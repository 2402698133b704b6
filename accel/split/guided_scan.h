// A cut from one uniform pass over all three axes and one more where that one says it pays. Ours;
// the passes are those of Hunt, Mark, Stoll 2006, section 6.1.
#pragma once

#include <cstdint>
#include <optional>

#include "accel/kdtree/reference.h"
#include "accel/split/cost_model.h"

namespace sightline::accel::split {

/// How a list is cut when counts guide where it is looked at.
struct GuidedRule {
  SahConstants cost;
  /// Planes an axis in the first pass, the cell's faces included. Range 2 to
  /// kdtree::kUniformPlanes.
  std::uint32_t uniform_samples = 8;
  bool refine_all_axes = false;  ///< In the second pass; else the most promising.
  bool once = false;             ///< No second pass.
};

/// The cheapest of the planes looked at, if it is cheaper than a leaf. Two passes, or one where the
/// first is known already (CellRefs::first) or where nothing can be gained.
///
/// C_L and C_R only rise and fall, so what was counted at the ends of a segment between two planes
/// bounds the cost within. The second pass looks at kScanWidth planes in the segments that may beat
/// the best plane known, more in those that may by more; each of them then moves, at no cost, to
/// the bound beside it on its cheaper side: between bounds the cost is linear.
std::optional<kdtree::Split> choose_guided(const kdtree::CellRefs& list, const GuidedRule& rule,
                                           kdtree::BuildCounters& counters);

}  // namespace sightline::accel::split

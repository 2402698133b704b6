// Where a peer's answers differ from ours, and whether that can be excused.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "accel/geometry/ray.h"
#include "scenegraph/revision/snapshot.h"

namespace sightline::bench {

struct Disagreement {
  std::uint64_t differences = 0;  ///< Rays whose (hit or miss, node, primitive) differ.
  std::uint64_t checked = 0;      ///< Of these, evenly spread, held against the oracle.
  /// Of the checked: neither a tie, nor an edge, nor an end of the ray within 1e-5 explains it.
  std::uint64_t unexplained = 0;
};

/// Ours are taken for right (they are checked elsewhere). For `any`, hit or miss alone counts.
Disagreement explain(std::shared_ptr<const scenegraph::revision::Snapshot> snapshot,
                     std::span<const accel::geometry::Ray> rays,
                     std::span<const accel::geometry::Hit> ours,
                     std::span<const accel::geometry::Hit> theirs, bool any);

}  // namespace sightline::bench

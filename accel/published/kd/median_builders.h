// Splits at the spatial median or at the object median: baselines for the heuristics. Source:
// Wald, Havran 2006, section 2.1; for the object median the survey's section 4.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "accel/kdtree/reference.h"

namespace sightline::accel::published::kd {

/// When median splits stop; they have no cost to stop them.
struct MedianStop {
  /// Cells of at most this many references are leaves. Range 1 to 1e6.
  std::uint32_t leaf_size = 8;
  /// Cells this deep are leaves. Range 0 to 80; 0: 8 + 1.3 log2 N (Havran 2000).
  std::uint32_t max_depth = 0;

  bool operator==(const MedianStop&) const = default;

  std::optional<std::string> check() const;
  int depth_bound(std::size_t references) const;
};

/// Splits at the middle of the cell, along the axes in turn. An axis whose middle keeps no
/// reference out of a half is skipped; if all are, the cell is a leaf.
struct SpatialMedianBuilder {
  MedianStop stop{};

  bool operator==(const SpatialMedianBuilder&) const = default;

  std::optional<std::string> check() const { return stop.check(); }
  int depth_bound(std::size_t references) const { return stop.depth_bound(references); }

  /// Touches: one pass. Threads: any.
  std::optional<kdtree::Split> choose(const kdtree::CellRefs& cell,
                                      kdtree::BuildCounters& counters) const;

  bool clips() const { return false; }
};

/// Splits at the median of the centres of the parts of boxes in the cell, along its longest axis.
/// If one side then has all references, the next longest axis is tried; if no axis is left, the
/// cell is a leaf.
struct ObjectMedianBuilder {
  MedianStop stop{};

  bool operator==(const ObjectMedianBuilder&) const = default;

  std::optional<std::string> check() const { return stop.check(); }
  int depth_bound(std::size_t references) const { return stop.depth_bound(references); }

  /// Touches, per axis: one pass for the centres, two to select the median, one to count the sides.
  /// Threads: any.
  std::optional<kdtree::Split> choose(const kdtree::CellRefs& cell,
                                      kdtree::BuildCounters& counters) const;

  bool clips() const { return false; }
};

}  // namespace sightline::accel::published::kd

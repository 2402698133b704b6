// Where spatial splits are tried: parameters of the split bounding volume hierarchy. Source: Stich,
// Friedrich, Dietrich 2009, "Spatial Splits in Bounding Volume Hierarchies".
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace sightline::accel::published::bvh {

struct SpatialRule {
  /// Where the children of the best object split overlap in a box of more than this share of the
  /// root's surface, a spatial split is looked for (section 4.5). 0: wherever they overlap; 1:
  /// nowhere. Range 0 to 1.
  double alpha = 1e-5;
  /// ... and of at least this share of the node's own surface: below it, a spatial split seldom
  /// pays. 0: as in the paper; 0.2 finds almost the same splits in half the time. Range 0 to 1.
  double node_overlap = 0;
  std::uint32_t bins = 256;  ///< An axis (section 4.2). Range 2 to 256.
  /// References that straddle the plane go to one side alone where that is cheaper (section 4.4).
  bool unsplit = true;
  /// How many references splits may add at most, per reference there is; where that is too few, the
  /// splits that gain most are made. Range 0 to 63.
  double budget = 3;

  bool operator==(const SpatialRule&) const = default;

  /// Which parameter is out of range, and the range; nothing if all are fine.
  std::optional<std::string> check() const;

  /// Whether any spatial split is made.
  bool splits() const { return alpha < 1 && budget > 0; }

  /// How many references there may be in the end if there are so many in the beginning, fewer than
  /// 2^31. Below 2^31.
  std::size_t most_references(std::size_t references) const;
};

}  // namespace sightline::accel::published::bvh

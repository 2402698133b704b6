// Parameters of spatial splits (split bounding volume hierarchy). Source: Stich,
// Friedrich, Dietrich 2009, "Spatial Splits in Bounding Volume Hierarchies".
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace sightline::accel::published::bvh {

struct SpatialRule {
  /// A spatial split is tried where the children of the best object split overlap in a box of more
  /// than this share of the root's surface (section 4.5). 0: wherever they overlap; 1: never. Range
  /// 0 to 1.
  double alpha = 1e-5;
  /// The overlap must also have at least this share of the node's own surface; below it, a spatial
  /// split seldom pays. 0: as in the paper; 0.2 finds almost the same splits in half the time.
  /// Range 0 to 1.
  double node_overlap = 0;
  std::uint32_t bins = 256;  ///< Bins per axis (section 4.2). Range 2 to 256.
  /// References that straddle the plane go to one side only where that is cheaper (section 4.4).
  bool unsplit = true;
  /// References that splits may add, per reference of the mesh. If that is too few for all splits,
  /// those that save most are made. Range 0 to 63.
  double budget = 3;

  bool operator==(const SpatialRule&) const = default;

  /// A message that names a parameter out of range, and its range; nothing if all are in range.
  std::optional<std::string> check() const;

  /// Whether any spatial split is tried.
  bool splits() const { return alpha < 1 && budget > 0; }

  /// Limit on the references of a hierarchy over `references` references (fewer than 2^31). Below
  /// 2^31.
  std::size_t most_references(std::size_t references) const;
};

}  // namespace sightline::accel::published::bvh

// Parameters of splitting references before a hierarchy is built.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace sightline::accel::published::bvh {

/// Limits on pieces: by their share of the root, or by their number.
struct PreSplitRule {
  /// Pieces are split while they are larger than this share of the root: in surface (Ernst, Greiner
  /// 2007) or in volume (Dammertz, Keller 2008). Range 0 to 1; ignored if there is a budget.
  double threshold = 1e-4;
  /// Pieces per reference, on average. The largest are split first until there are this many, which
  /// equals a threshold chosen for that number. 0: threshold alone. Range 0 to 64; below 1 nothing
  /// is split.
  double budget = 0;

  bool operator==(const PreSplitRule&) const = default;

  /// A message that names a parameter out of range, and its range; nothing if all are in range.
  std::optional<std::string> check() const;

  /// Limit on pieces per reference, whatever the threshold.
  static constexpr double kMostPieces = 64;

  /// Limit on the pieces of a list of that many references. Below 2^31.
  std::size_t most_pieces(std::size_t references) const;
};

}  // namespace sightline::accel::published::bvh

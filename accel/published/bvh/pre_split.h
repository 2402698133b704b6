// Which references are split before a hierarchy is built.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace sightline::accel::published::bvh {

/// How small pieces become: bounded by a share of the whole, or by their number.
struct PreSplitRule {
  /// Pieces are split while they are larger than this share of the root: in surface (Ernst, Greiner
  /// 2007) or in volume (Dammertz, Keller 2008). Range 0 to 1; not looked at if there is a budget.
  double threshold = 1e-4;
  /// Pieces a reference, on average: the largest are split first until there are so many, which is
  /// the same as knowing the threshold that gives as many. 0: by threshold alone. Range 0 to 64;
  /// below 1 there is nothing to split.
  double budget = 0;

  bool operator==(const PreSplitRule&) const = default;

  /// Which parameter is out of range, and the range; nothing if all are fine.
  std::optional<std::string> check() const;

  /// Whatever the threshold, there are no more than this.
  static constexpr double kMostPieces = 64;

  /// How many pieces there may be of so many references. Below 2^31.
  std::size_t most_pieces(std::size_t references) const;
};

}  // namespace sightline::accel::published::bvh

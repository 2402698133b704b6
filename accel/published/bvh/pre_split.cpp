// Ranges of the parameters of splitting beforehand.
#include "accel/published/bvh/pre_split.h"

#include <algorithm>

#include "accel/split/out_of_range.h"

namespace sightline::accel::published::bvh {

std::optional<std::string> PreSplitRule::check() const {
  if (auto e = split::out_of_range("threshold", threshold, 0.0, 1.0)) return e;
  return split::out_of_range("budget", budget, 0.0, kMostPieces);
}

std::size_t PreSplitRule::most_pieces(std::size_t references) const {
  constexpr double kMost = (std::size_t{1} << 31) - 1;
  const double each = budget > 0 ? budget : kMostPieces;
  return static_cast<std::size_t>(std::min(each * static_cast<double>(references), kMost));
}

}  // namespace sightline::accel::published::bvh

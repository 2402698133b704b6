// Ranges of the parameters of spatial splits.
#include "accel/published/bvh/spatial_split.h"

#include <algorithm>

#include "accel/split/out_of_range.h"

namespace sightline::accel::published::bvh {

std::optional<std::string> SpatialRule::check() const {
  if (auto e = split::out_of_range("alpha", alpha, 0.0, 1.0)) return e;
  if (auto e = split::out_of_range("node_overlap", node_overlap, 0.0, 1.0)) return e;
  if (auto e = split::out_of_range("spatial_bins", bins, 2u, 256u)) return e;
  return split::out_of_range("budget", budget, 0.0, 63.0);
}

std::size_t SpatialRule::most_references(std::size_t references) const {
  if (!splits()) return references;
  constexpr double kMost = (std::size_t{1} << 31) - 1;
  const double more = budget * static_cast<double>(references);
  return static_cast<std::size_t>(std::min(static_cast<double>(references) + more, kMost));
}

}  // namespace sightline::accel::published::bvh

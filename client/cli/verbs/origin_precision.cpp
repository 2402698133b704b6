// Compares the spacing of float32 values with the size of a scene.
#include "client/cli/verbs/origin_precision.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sightline::client::cli::verbs {

RaySource<float> watch_reach(RaySource<float> source, float& reach) {
  return [source = std::move(source), &reach](const RayColumns<float>& buffer) {
    auto rows = source(buffer);
    if (!rows) return rows;
    for (const float x : buffer.origins.first(3 * *rows)) {
      if (std::isfinite(x)) reach = std::max(reach, std::abs(x));
    }
    return rows;
  };
}

std::string origin_precision_warning(float reach, const std::array<double, 6>& bounds,
                                     files::RowKind asked) {
  const double diagonal =
      std::hypot(bounds[3] - bounds[0], bounds[4] - bounds[1], bounds[5] - bounds[2]);
  const auto spacing =
      static_cast<double>(std::nextafter(reach, std::numeric_limits<float>::infinity()) - reach);
  if (!(spacing > kMaxSpacing * diagonal)) return {};
  return fmt::format(
      "{} up to {:.3g} from the origin, where float32 values are {:.2g} apart; the scene's "
      "diagonal "
      "is {:.3g}: write them as float64",
      asked == files::RowKind::kRays ? "rays are float32 and begin" : "points are float32 and lie",
      reach, spacing, diagonal);
}

}  // namespace sightline::client::cli::verbs

// A selection by distance.
#include "client/load/coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "client/cli/picture/camera.h"

namespace sightline::client::load {

std::vector<std::size_t> nearest(std::span<const std::array<double, 3>> points,
                                 const std::array<double, 3>& center, double share) {
  std::vector<double> distances;
  distances.reserve(points.size());
  for (const auto& point : points) {
    const double distance = cli::picture::length(cli::picture::sub(point, center));
    distances.push_back(std::isnan(distance) ? std::numeric_limits<double>::infinity() : distance);
  }
  std::vector<std::size_t> chosen(points.size());
  std::iota(chosen.begin(), chosen.end(), std::size_t{0});
  const double wanted = std::ceil(std::clamp(share, 0.0, 1.0) * static_cast<double>(points.size()));
  const auto count =
      std::min(std::max<std::size_t>(static_cast<std::size_t>(wanted), 1), points.size());
  if (count < chosen.size()) {
    std::nth_element(chosen.begin(), chosen.begin() + static_cast<std::ptrdiff_t>(count),
                     chosen.end(),
                     [&](std::size_t a, std::size_t b) { return distances[a] < distances[b]; });
    chosen.resize(count);
    std::sort(chosen.begin(), chosen.end());
  }
  return chosen;
}

}  // namespace sightline::client::load

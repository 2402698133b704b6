// A fan.
#include "client/importer/triangulate.h"

#include <cstddef>

namespace sightline::client::importer {

void triangulate(const std::vector<Point>&, std::span<const std::uint32_t> corners,
                 std::vector<Face>& faces) {
  for (std::size_t k = 2; k < corners.size(); ++k) {
    faces.push_back({corners[0], corners[k - 1], corners[k]});
  }
}

}  // namespace sightline::client::importer

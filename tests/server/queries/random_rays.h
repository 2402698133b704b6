// Random rays at the unit cube.
#pragma once

#include <vector>

#include "accel/geometry/ray.h"
#include "tests/support/random.h"

namespace sightline::tests {

inline std::vector<accel::geometry::Ray> random_rays(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<accel::geometry::Ray> rays(count);
  for (accel::geometry::Ray& ray : rays) {
    ray.origin = {random.uniform(-1, 2), random.uniform(-1, 2), random.uniform(-1, 2)};
    ray.direction = random.direction();
  }
  return rays;
}

}  // namespace sightline::tests

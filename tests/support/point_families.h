// Scenes and points, by family, at which searches for the nearest face fail: what the tests of
// points and `sightline-bench check --kind nearest` ask.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "tests/support/point_scenes.h"

namespace sightline::tests {

struct PointFamily {
  std::string_view name;
  std::string_view what;
  std::vector<ScenePart> (*make)();
  /// `count` points, which are finite; the seed determines them.
  std::vector<accel::geometry::Vec3d> (*points)(const scenegraph::revision::Snapshot& snapshot,
                                                std::uint64_t seed, std::size_t count);
  /// The share of the number of points that other families have: less than 1 where each point has
  /// very many faces at one distance.
  double share = 1;
};

const std::vector<PointFamily>& point_families();

}  // namespace sightline::tests

// Random rays and queries over a plain scene.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tests/support/kinds.h"
#include "tests/support/plain_scene.h"
#include "tests/support/random.h"

namespace sightline::tests {

/// An existing root, excluded nodes, culled sides; each of them only sometimes.
struct RandomQuestion {
  std::vector<accel::geometry::Ray> rays;
  scenegraph::model::NodeId root = 0;
  std::vector<scenegraph::model::NodeId> excluded;
  accel::geometry::Culling culling = accel::geometry::Culling::kNone;
  std::uint32_t max_hits = 256;
};

/// The rays pass through points of triangles, from near and far, some with limits and masks.
/// Without a mesh there are none.
RandomQuestion random_question(const PlainScene& scene, std::size_t rays, Random& random);

/// Compares answers of all kinds with brute force over that scene.
KindComparison judge(const PlainScene& scene, const RandomQuestion& question,
                     const KindAnswers& answers);

}  // namespace sightline::tests

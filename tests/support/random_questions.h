// Rays and what is asked of them, drawn at random over a plain scene.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tests/support/kinds.h"
#include "tests/support/plain_scene.h"
#include "tests/support/random.h"

namespace sightline::tests {

/// A root that there is, nodes to leave out, sides to leave out; each of them not always.
struct RandomQuestion {
  std::vector<accel::geometry::Ray> rays;
  scenegraph::model::NodeId root = 0;
  std::vector<scenegraph::model::NodeId> excluded;
  accel::geometry::Culling culling = accel::geometry::Culling::kNone;
  std::uint32_t max_hits = 256;
};

/// The rays go through points of triangles, from near by and from far, some with limits and masks.
/// Without a mesh there are none.
RandomQuestion random_question(const PlainScene& scene, std::size_t rays, Random& random);

/// Every kind of answer against brute force over that scene.
KindComparison judge(const PlainScene& scene, const RandomQuestion& question,
                     const KindAnswers& answers);

}  // namespace sightline::tests

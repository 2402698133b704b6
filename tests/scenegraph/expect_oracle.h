// Compares all kinds of query at a scene with the oracle.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "scenegraph/scene.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/brute_force.h"
#include "tests/support/kinds.h"

namespace sightline::tests {

/// Casts random rays through the current revision. Returns the number of hits that were compared.
inline std::uint64_t expect_oracle(
    const scenegraph::Scene& scene, std::size_t count, std::uint64_t seed,
    accel::geometry::Culling culling = accel::geometry::Culling::kNone) {
  const auto snapshot = scene.snapshot();
  if (snapshot->bounds().empty()) return 0;
  const std::vector<accel::geometry::Ray> rays = rays_through(*snapshot, count, seed);
  scenegraph::TraceOptions options;
  options.culling = culling;
  const KindAnswers answers = ask_all_kinds(*snapshot, rays, options);
  EXPECT_EQ(contradiction(answers, options.max_hits), "");
  const KindComparison compared =
      compare_kinds(rays, answers, BruteForce(snapshot), {.culling = culling});
  EXPECT_EQ(compared.mismatches, 0u) << compared.report();
  return compared.hits;
}

}  // namespace sightline::tests

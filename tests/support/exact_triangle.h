// One ray against one triangle in 113 bits: the oracle's decision.
#pragma once

#include <array>
#include <optional>

#include "tests/support/quad.h"
#include "tests/support/reference.h"

namespace sightline::tests {

/// The candidate of the triangle (in world space) for the ray, without node and primitive; its
/// normal and side are those of the winding in the world. `scale`
/// is the largest coordinate involved. Nothing if the ray misses by more than the tolerance.
std::optional<Candidate> test_triangle(const accel::geometry::Ray& ray,
                                       const std::array<QuadVec, 3>& corners, double scale,
                                       const Tolerance& tolerance);

}  // namespace sightline::tests

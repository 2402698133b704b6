// How many triangles of a patch a line must hit.
#pragma once

#include <array>
#include <cstdint>

#include "tests/fuzz/hard_case.h"
#include "tests/support/rational_hit.h"

namespace sightline::tests {

enum class ExpectedSum : std::uint8_t {
  kAny,        ///< The line passes through the border of the patch, or beside it.
  kOne,        ///< Through the interior of a patch that covers the surroundings of the line once.
  kNoneOrTwo,  ///< At a fold, or a convex body.
};

using ExactVertices = std::array<DyadicVec, HardCase::kMaxVertices>;

/// Follows from the signs of plain determinants over the border of the patch alone: neither the
/// perturbation nor the inner edges have a part in it.
ExpectedSum expected_sum(const RationalRay& ray, const HardCase& hard, const ExactVertices& v);

}  // namespace sightline::tests

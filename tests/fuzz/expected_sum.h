// How many triangles of a patch a line must hit.
#pragma once

#include <array>
#include <cstdint>

#include "tests/fuzz/hard_case.h"
#include "tests/support/rational_hit.h"

namespace sightline::tests {

enum class ExpectedSum : std::uint8_t {
  kAny,        ///< The line passes through the border of the patch, or outside it.
  kOne,        ///< Through the interior of a patch that covers the line's surroundings once.
  kNoneOrTwo,  ///< At a fold, or a convex body.
};

using ExactVertices = std::array<DyadicVec, HardCase::kMaxVertices>;

/// Computed only from the signs of plain determinants over the border of the patch: neither the
/// perturbation nor the inner edges are used.
ExpectedSum expected_sum(const RationalRay& ray, const HardCase& hard, const ExactVertices& v);

}  // namespace sightline::tests

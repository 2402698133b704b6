// One builder held against a search without a tree, and that against exact arithmetic.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tests/fuzz/builder/soup_case.h"

namespace sightline::tests {

struct SoupTally {
  std::uint64_t rays = 0;
  std::uint64_t hits = 0;  ///< Pairs of a ray and a triangle.
};

/// What is wrong, or nothing. The builder's tree, built whole and grown by the rays, must answer
/// each of them as a search through all triangles does, to the bit: nearest, any, count. Which
/// triangles are hit is judged by RationalRay for the first ray of meshes that are small.
std::optional<std::string> check_soup(const SoupCase& soup, SoupTally& tally);

}  // namespace sightline::tests

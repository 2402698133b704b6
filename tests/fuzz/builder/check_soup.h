// One builder against a search without a tree, and that search against exact arithmetic.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tests/fuzz/builder/soup_case.h"

namespace sightline::tests {

struct SoupTally {
  std::uint64_t rays = 0;
  std::uint64_t hits = 0;  ///< Pairs of a ray and a triangle that it hits.
};

/// Describes an error, or nothing. The builder's tree, built fully and grown by the rays, must
/// answer every ray exactly as a search of all triangles does: nearest, any, count. For small
/// meshes, RationalRay checks which triangles the first rays hit.
std::optional<std::string> check_soup(const SoupCase& soup, SoupTally& tally);

}  // namespace sightline::tests

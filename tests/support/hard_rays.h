// Rays on which walks and tests fail: through vertices and edges, in planes, along axes, from
// surfaces.
#pragma once

#include <cstdint>
#include <vector>

#include "accel/geometry/ray.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

/// The number of kinds that make_hard_rays cycles through.
inline constexpr std::size_t kHardRayKinds = 8;

/// Cycles through eight kinds: through points of the box from far away, from inside, through
/// vertices, through points of edges, along the 26 directions to neighbors of a lattice through a
/// vertex (zeros of both signs), the same from the vertex itself, from a plane through a vertex
/// along that plane, and with limits that end at a vertex. All rays are valid. Without a finite
/// vertex there are none.
std::vector<accel::geometry::Ray> make_hard_rays(const TestMesh& mesh, std::size_t count,
                                                 std::uint64_t seed);

}  // namespace sightline::tests

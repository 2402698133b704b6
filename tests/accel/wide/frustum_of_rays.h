// Rays through one point on which frustums fail.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "accel/geometry/ray.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

/// From one origin far away, near, inside, or on a vertex, an edge or a face; most of them around
/// one axis, with slopes up to 2, through vertices, edges and faces where those allow it. Some run
/// along axes, or do not belong to the frustum: by direction, origin or limits. All rays are valid.
std::vector<accel::geometry::Ray> frustum_from_origin(const TestMesh& mesh, std::size_t count,
                                                      std::uint64_t seed);

/// Toward one end at t = 1 in places as above, exactly or nearly; most limits lie in [0, 1].
std::vector<accel::geometry::Ray> frustum_toward_end(const TestMesh& mesh, std::size_t count,
                                                     std::uint64_t seed);

}  // namespace sightline::tests

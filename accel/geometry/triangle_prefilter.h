// Tests many triangles against one ray in floats, and rejects those that the ray certainly misses.
// The hit rule decides the others, so that answers do not depend on this test.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/geometry/local_ray.h"
#include "accel/geometry/triangle_mesh.h"

namespace sightline::accel::geometry {

/// A ray, and the plane on which it projects to a point: x and y, sheared along z, the axis of the
/// direction's largest component. Source: Woop, Benthin, Wald 2013, "Watertight Ray/Triangle
/// Intersection"; they decide hits in floats, here floats only reject.
struct ShearedRay {
  std::size_t z = 2;               ///< Which axis z is; x and y are the next two, cyclically.
  std::array<float, 3> origin{};   ///< x, y, z.
  float shear_x = 0, shear_y = 0;  ///< A point p projects to x = p.x - shear_x p.z; y likewise.
  float error = 0;  ///< Upper bound on the error of projected points from rounding the origin.
};
ShearedRay sheared(const LocalRay& ray);

/// Largest number of triangles in one call of candidate_mask.
inline constexpr std::size_t kPrefilterBatch = 64;

/// Bit i is set if faces[i] is not certainly missed; if it is not set, `intersect` returns no hit.
/// faces: 1 to kPrefilterBatch, with finite vertices.
std::uint64_t candidate_mask(const MeshView& mesh, const ShearedRay& ray,
                             std::span<const std::uint32_t> faces);

}  // namespace sightline::accel::geometry

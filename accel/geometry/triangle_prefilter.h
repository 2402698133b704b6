// Many triangles against one ray at a time: which of them it certainly misses, found in floats.
// What is left is for the hit rule, so that answers do not depend on this.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/geometry/local_ray.h"
#include "accel/geometry/triangle_mesh.h"

namespace sightline::accel::geometry {

/// A ray, and the plane in which it is seen as a point: x and y, sheared along z, the axis of the
/// direction's largest component (after Woop, Benthin, Wald 2013, "Watertight Ray/Triangle
/// Intersection"; they decide in floats what is only sorted out here).
struct ShearedRay {
  std::size_t z = 2;               ///< Which axis z is; x and y are the next two, cyclically.
  std::array<float, 3> origin{};   ///< x, y, z.
  float shear_x = 0, shear_y = 0;  ///< A point p is seen at p.x - shear_x p.z, likewise y.
  float error = 0;                 ///< At most, of what is seen, by rounding the origin.
};
ShearedRay sheared(const LocalRay& ray);

/// At most so many triangles at once.
inline constexpr std::size_t kPrefilterBatch = 64;

/// Bit i: the i-th of `faces` is not certainly missed. Where it is not set, `intersect` says that
/// there is no hit. Faces: 1 to kPrefilterBatch, with finite vertices.
std::uint64_t candidate_mask(const MeshView& mesh, const ShearedRay& ray,
                             std::span<const std::uint32_t> faces);

}  // namespace sightline::accel::geometry

// A mesh as builders and the hit rule use it: two arrays, not owned.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "accel/geometry/vec3.h"

namespace sightline::accel::geometry {

using Face = std::array<std::uint32_t, 3>;

/// A face slot that holds no triangle (a line or a point in the file): it keeps its number and is
/// never hit.
inline constexpr std::uint32_t kNoVertex = 0xffffffffu;

/// Indices are in range or kNoVertex; vertices may be non-finite (such faces are never referenced).
struct MeshView {
  std::span<const Vec3f> vertices;
  std::span<const Face> faces;
  /// Whether every face is a triangle with finite vertices; false if that is not known.
  bool all_finite = false;
};

}  // namespace sightline::accel::geometry

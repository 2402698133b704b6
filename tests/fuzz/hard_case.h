// A ray and a patch of triangles around the edge or vertex at which it is aimed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/geometry/triangle_mesh.h"
#include "accel/geometry/vec3.h"

namespace sightline::tests {

enum class Patch : std::uint8_t {
  kTriangle,     ///< Vertices 0, 1, 2.
  kPair,         ///< Edge 0 1 with one triangle to 2 and one to 3.
  kFan,          ///< Vertex 0 surrounded by the others.
  kTetrahedron,  ///< Four vertices, four faces.
};
inline constexpr std::size_t kPatches = 4;

/// At most eight triangles. The faces list their vertices in any order.
struct HardCase {
  static constexpr std::size_t kMaxVertices = 9;
  static constexpr std::size_t kMaxFaces = 8;

  Patch patch = Patch::kTriangle;
  accel::geometry::Vec3d origin, direction;
  std::size_t vertex_count = 0, face_count = 0;
  std::array<accel::geometry::Vec3f, kMaxVertices> vertex;
  std::array<accel::geometry::Face, kMaxFaces> face;

  std::span<const accel::geometry::Face> faces() const { return {face.data(), face_count}; }
  /// Sets vertex_count and the faces; `rim` is the number of vertices around a fan.
  void connect(Patch as, std::size_t rim = 0);
};

inline void HardCase::connect(Patch as, std::size_t rim) {
  patch = as;
  face_count = 0;
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
    face[face_count++] = {static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b),
                          static_cast<std::uint32_t>(c)};
  };
  vertex_count = as == Patch::kTriangle ? 3 : as == Patch::kFan ? rim + 1 : 4;
  if (as == Patch::kFan) {
    for (std::size_t i = 0; i < rim; ++i) add(0, 1 + i, 1 + (i + 1) % rim);
    return;
  }
  add(0, 1, 2);
  if (as != Patch::kTriangle) add(1, 0, 3);
  if (as == Patch::kTetrahedron) {
    add(1, 3, 2);
    add(0, 2, 3);
  }
}

}  // namespace sightline::tests

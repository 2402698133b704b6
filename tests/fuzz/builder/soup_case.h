// Fuzzer bytes as a mesh that is difficult for builders, a builder, and rays.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "accel/geometry/facing.h"
#include "accel/geometry/ray.h"
#include "accel/geometry/triangle_mesh.h"
#include "accel/mesh/mesh_tree.h"
#include "tests/fuzz/bytes.h"

namespace sightline::tests {

struct SoupCase {
  std::string_view builder;  ///< One of accel::builder_names().
  /// For set_parameter, which may refuse each of them.
  std::vector<std::pair<std::string_view, std::string>> parameters;
  accel::mesh::References references = accel::mesh::References::kRuns;
  bool in_parallel = false;
  accel::geometry::Culling culling = accel::geometry::Culling::kNone;
  std::vector<accel::geometry::Vec3f> vertices;  ///< May be NaN or infinite.
  std::vector<accel::geometry::Face> faces;      ///< Indices are valid, or all kNoVertex.
  std::vector<accel::geometry::Ray> rays;        ///< May be invalid rays.

  accel::geometry::MeshView view() const { return {vertices, faces}; }
};

/// Any bytes make a case: up to 60 triangles, and copies of some of them, each moved by a step or
/// not at all, up to kMostFaces.
SoupCase make_soup(Bytes bytes);

inline constexpr std::size_t kMostFaces = 400;

}  // namespace sightline::tests

// A few triangles and a packet of rays at them, from a fuzzer's bytes.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "accel/geometry/facing.h"
#include "accel/geometry/ray.h"
#include "accel/geometry/triangle_mesh.h"

namespace sightline::tests {

/// A ray and the best hit that it comes with.
struct AskedRay {
  accel::geometry::Ray ray;
  bool has_best = false;
  double best_t = std::numeric_limits<double>::max();
  std::uint64_t best_node = ~std::uint64_t{0};
};

/// The node of the triangles; other hits come before it or behind.
inline constexpr std::uint64_t kAskedNode = 5;

struct VerdictCase {
  std::vector<accel::geometry::Vec3f> vertices;
  std::vector<accel::geometry::Face> faces;
  std::vector<AskedRay> rays;
  accel::geometry::Culling culling = accel::geometry::Culling::kNone;
  std::uint64_t frames = 0;  ///< The seed of the frames in which check_flat() has the triangles.

  accel::geometry::MeshView view() const { return {vertices, faces}; }
};

/// Any bytes make a case: 1 to 8 triangles with finite vertices, and 1 to 16 valid rays, most of
/// them through a triangle or close to one.
VerdictCase decode_verdict_case(std::span<const std::uint8_t> data);

}  // namespace sightline::tests

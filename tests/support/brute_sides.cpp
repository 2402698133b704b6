// The definition of the side by normals, in 113 bits, over all faces of a node.
#include "tests/support/brute_sides.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "tests/support/distance_bounds.h"
#include "tests/support/quad.h"

namespace sightline::tests {
namespace {

using QuadCorners = std::array<QuadVec, 3>;  // Minus the point

Quad size_of(const QuadVec& v) { return Precision<Quad>::root(dot(v, v)); }

QuadCorners corners_from(const accel::geometry::Vec3d& p, const PlacedMesh& node,
                         const accel::geometry::Face& face) {
  QuadCorners corners;
  for (std::size_t i = 0; i < 3; ++i)
    corners[i] = transform(node.world_from_local, node.mesh.vertices[face[i]]) - widen(p);
  return corners;
}

QuadVec nearest_on_segment(const QuadVec& a, const QuadVec& b) {
  const QuadVec edge = b - a;
  const Quad along = -dot(a, edge), whole = dot(edge, edge);
  if (along <= 0) return a;
  return along >= whole ? b : a + edge * (along / whole);
}

bool is_inside(const QuadCorners& corners, const QuadVec& normal, const QuadVec& foot) {
  for (std::size_t i = 0; i < 3; ++i) {
    const QuadVec edge = corners[(i + 1) % 3] - corners[i];
    if (dot(normal, cross(edge, foot - corners[i])) <= 0) return false;
  }
  return true;
}

struct Nearest {
  QuadVec point, normal;  // The normal has length 1, or is 0
  Quad angle = 0;
  bool inside = false;
};

Quad angle_between(const QuadVec& a, const QuadVec& b) {
  return std::atan2(static_cast<long double>(size_of(cross(a, b))),
                    static_cast<long double>(dot(a, b)));
}

/// Points that are no farther from each other than `same` are one.
Nearest nearest_of(const QuadCorners& corners, Quad same) {
  Nearest nearest{corners[0], cross(corners[1] - corners[0], corners[2] - corners[0])};
  for (std::size_t i = 0; i < 3; ++i) {
    const QuadVec point = nearest_on_segment(corners[i], corners[(i + 1) % 3]);
    if (dot(point, point) < dot(nearest.point, nearest.point)) nearest.point = point;
  }
  const Quad size = size_of(nearest.normal);
  if (size == 0) return nearest;
  nearest.normal = nearest.normal * (1 / size);
  const QuadVec foot = nearest.normal * dot(nearest.normal, corners[0]);
  nearest.angle = std::acos(-1.0L);
  if (is_inside(corners, nearest.normal, foot) && size_of(foot - nearest.point) > same) {
    nearest.point = foot;
    nearest.angle = 2 * nearest.angle;
    nearest.inside = true;
    return nearest;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (size_of(nearest.point - corners[i]) > same) continue;
    nearest.angle =
        angle_between(corners[(i + 1) % 3] - corners[i], corners[(i + 2) % 3] - corners[i]);
  }
  return nearest;
}

Quad quad_determinant(const scenegraph::model::Affine& a) {
  const auto row = [&](std::size_t r) { return QuadVec{a.m[r], a.m[r + 1], a.m[r + 2]}; };
  return dot(row(0), cross(row(4), row(8)));
}

}  // namespace

std::optional<bool> is_behind(const PlacedMesh& node, std::uint32_t primitive,
                              const accel::geometry::Vec3d& p) {
  const QuadCorners corners = corners_from(p, node, node.mesh.faces[primitive]);
  const Quad same =
      1e-29 * std::max({size_of(corners[0]), size_of(corners[1]), size_of(corners[2])});
  const Nearest nearest = nearest_of(corners, same);
  QuadVec sum = nearest.normal * nearest.angle;
  Quad weights = nearest.angle;
  for (std::uint32_t f = 0; f < node.mesh.faces.size() && !nearest.inside; ++f) {
    const accel::geometry::Face& face = node.mesh.faces[f];
    if (f == primitive || face[0] >= node.mesh.vertices.size()) continue;
    QuadCorners other = corners_from(p, node, face);
    for (QuadVec& corner : other) corner = corner - nearest.point;
    const Nearest there = nearest_of(other, same);
    if (size_of(there.point) > same) continue;
    sum = sum + there.normal * there.angle;
    weights += there.angle;
  }
  const Quad product = dot(sum, nearest.point);
  constexpr Quad kUncertain = 1e-10;
  if (absolute(product) <= kUncertain * weights * size_of(nearest.point)) return std::nullopt;
  return (product > 0) != (quad_determinant(node.world_from_local) < 0);
}

}  // namespace sightline::tests

// Normals and nearest points in double-doubles, with bounds of their errors.
#include "accel/geometry/pseudonormal.h"

#include <algorithm>
#include <cmath>

#include "accel/geometry/angle.h"
#include "accel/geometry/bounded_signs.h"
#include "accel/geometry/closest_errors.h"
#include "accel/geometry/intersect.h"
#include "accel/geometry/local_ray.h"

namespace sightline::accel::geometry {
namespace {

/// The largest relative error of what is computed.
constexpr double kMostError = 0x1p-46;

Feature feature_of(const SeenFace& face) {
  const Feature feature =
      nearest_feature(BoundedSigns<double>(face, kSignShare, 0x1p+53 * face.error));
  if (feature.certain) return feature;
  return nearest_feature(BoundedSigns<DoubleDouble>(face, kFineSignShare, 0x1p+104 * face.error));
}

/// The nearest point as seen from p, and its error.
Vec3dd computed_foot(const SeenFace& face, const Feature& nearest, double& error) {
  const Vec3dd& corner = face.corner[nearest.index];
  if (nearest.part == Part::kCorner) {
    error = face.error;
    return corner;
  }
  if (nearest.part == Part::kEdge) {
    const Vec3dd& edge = face.edge[nearest.index];
    error = spread(face, 1, std::sqrt(square(edge)));
    return corner - edge * (dot(corner, edge) / dot(edge, edge));
  }
  const Vec3dd normal = cross(face.edge[2], face.edge[0]);
  error = spread(face, thinness(face, normal), shortest_edge(face));
  return normal * (dot(normal, corner) / dot(normal, normal));
}

/// Whether the point is on the segment from `corner` on, both seen from one point.
bool is_on(const Vec3dd& corner, const Vec3dd& edge, const Vec3dd& point, double off) {
  const Vec3dd from = point - corner;
  const DoubleDouble whole = dot(edge, edge), along = dot(from, edge);
  if (!(along.high > 0 && (whole - along).high > 0)) return false;
  return square(cross(edge, from)) <= off * off * whole.high;
}

/// Whether the point is in the plane of the face, and not on its outer side of an edge.
bool is_in(const FaceNormal& face, const Vec3dd& point, double off) {
  if (face.area.high == 0) return false;
  const Vec3dd from = point - face.seen.corner[0];
  if (!(std::fabs(dot(face.normal, from).high) <= off)) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3dd side = cross(face.seen.edge[i], point - face.seen.corner[i]);
    if (!(dot(face.normal, side).high > 0)) return false;
  }
  return true;
}

}  // namespace

bool computed_normal(const Vec3d& p, const std::array<double, 12>& world_from_local,
                     const std::array<Vec3f, 3>& vertices, FaceNormal& face) {
  if (!see(without_smallest(p), world_from_local, vertices, face.seen)) return false;
  face.normal = {};
  face.area = {};
  const auto& [a, b, c] = vertices;
  if (a == b || b == c || c == a) return true;
  const Vec3dd normal = cross(face.seen.edge[2], face.seen.edge[0]);
  // A smaller square may have lost bits, or be 0.
  if (!(square(normal) >= 0x1p-900)) return false;
  const double error = 0x1p-98 + 8 * face.seen.error / shortest_edge(face.seen);
  if (!(thinness(face.seen, normal) * error <= kMostError)) return false;
  const DoubleDouble whole = dot(normal, normal);
  face.normal = normal * root_of_quotient({1, 0}, whole);
  face.area = root_of_quotient(whole, {1, 0});
  return true;
}

bool computed_nearest(const Vec3d& p, const std::array<double, 12>& world_from_local,
                      const std::array<Vec3f, 3>& vertices, double distance,
                      NearestPoint& nearest) {
  const Vec3d from = without_smallest(p);
  SeenFace face;
  if (!see(from, world_from_local, vertices, face)) return false;
  nearest.feature = feature_of(face);
  if (!nearest.feature.certain) return false;
  double error = 0;
  const Vec3dd foot = computed_foot(face, nearest.feature, error);
  if (!(error <= kMostError * distance)) return false;
  nearest.position = rounded_sum(foot, from);
  set_view(from, foot, error, reach(face), longest_edge(world_from_local, vertices), nearest);
  if (nearest.view != from) return false;
  const double down = std::ldexp(1.0, -std::ilogb(distance));
  for (std::size_t axis = 0; axis < 3; ++axis)
    nearest.from_p[axis] = {foot[axis].high * down, foot[axis].low * down};
  return true;
}

void set_view(const Vec3d& p, const Vec3dd& from_p, double error, double reach, double longest,
              NearestPoint& nearest) {
  const double unit = 0x1p-52 * std::max(max_norm(nearest.position), longest);
  nearest.off = unit + error;
  nearest.view = p;
  nearest.seen = from_p;
  nearest.seen_off = 8 * error + 0x1p-96 * reach;
  if (nearest.seen_off <= unit) return;
  nearest.off = unit;
  nearest.view = nearest.position;
  nearest.seen = {};
  nearest.seen_off = 4 * unit + 2 * kSmallestRay;  // Smaller coordinates of a point are not seen
}

DoubleDouble angle_at(const FaceNormal& face, const Feature& feature) {
  if (feature.part == Part::kEdge) return kPi;
  if (feature.part == Part::kInside) return kPi * DoubleDouble{2};
  const Vec3dd& from = face.seen.edge[feature.index];
  const Vec3dd& to = face.seen.edge[corner_before(feature.index)];
  return angle_of(face.area, -dot(from, to));
}

Feature part_at(const FaceNormal& face, const Vec3dd& point, double off) {
  off += 8 * face.seen.error + 0x1p-96 * reach(face.seen);
  for (std::size_t i = 0; i < 3; ++i) {
    if (max_norm(high(point - face.seen.corner[i])) <= off) return {Part::kCorner, i};
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (is_on(face.seen.corner[i], face.seen.edge[i], point, 2 * off)) return {Part::kEdge, i};
  }
  if (is_in(face, point, 4 * off)) return {Part::kInside};
  return {};
}

bool is_mirrored(const std::array<double, 12>& world_from_local) {
  std::array<Vec3dd, 3> rows;
  for (std::size_t i = 0; i < 3; ++i) {
    const double* const m = &world_from_local[4 * i];
    // By powers of two, so that no product overflows; what underflows is too small to matter.
    const int down = -std::ilogb(max_norm({m[0], m[1], m[2]}));
    for (std::size_t j = 0; j < 3; ++j) rows[i][j] = {std::ldexp(m[j], down)};
  }
  return dot(rows[0], cross(rows[1], rows[2])).high < 0;
}

double longest_edge(const std::array<double, 12>& world_from_local,
                    const std::array<Vec3f, 3>& vertices) {
  const auto& m = world_from_local;
  double longest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d edge = Vec3d(vertices[corner_after(i)]) - Vec3d(vertices[i]);
    const auto row = [&](std::size_t r) {
      return m[r] * edge.x + m[r + 1] * edge.y + m[r + 2] * edge.z;
    };
    longest = std::max(longest, max_norm({row(0), row(4), row(8)}));
  }
  return longest;
}

}  // namespace sightline::accel::geometry

// The distance rule: doubles choose the nearest corner, edge or inside, double-doubles compute the
// distance, both with proven bounds; integers decide the rest.
#include "accel/geometry/closest.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "accel/geometry/bounded_signs.h"
#include "accel/geometry/closest_errors.h"
#include "accel/geometry/closest_exact.h"
#include "accel/geometry/intersect.h"

namespace sightline::accel::geometry {
namespace {

using Matrix = std::array<double, 12>;
using Vertices = std::array<Vec3f, 3>;

/// The square of a distance as a quotient.
struct SquaredDistance {
  DoubleDouble numerator, denominator;
  double error = 0;  // Of its root
};

SquaredDistance squared_distance(const SeenFace& face, const Feature& feature) {
  const Vec3dd& corner = face.corner[feature.index];
  if (feature.part == Part::kCorner) {
    const DoubleDouble square = dot(corner, corner);
    return {square, {1, 0}, 0x1p-100 * std::sqrt(square.high)};
  }
  if (feature.part == Part::kEdge) {
    const Vec3dd& edge = face.edge[feature.index];
    const Vec3dd moment = cross(edge, corner);
    return {dot(moment, moment), dot(edge, edge), 0x1p-100 * reach(face)};
  }
  const Vec3dd normal = cross(face.edge[2], face.edge[0]);
  const DoubleDouble height = dot(normal, corner);
  return {height * height, dot(normal, normal), 0x1p-99 * thinness(face, normal) * reach(face)};
}

/// The distance of a feature, unless its last bit is in doubt.
std::optional<double> rounded_distance(const SeenFace& face, const Feature& feature) {
  if (feature.part == Part::kUnknown) return std::nullopt;
  const SquaredDistance square = squared_distance(face, feature);
  if (square.numerator.high == 0 && feature.part == Part::kCorner && face.error == 0) return 0.0;
  // Squares below this may have lost bits.
  constexpr double kLeastSquare = 0x1p-900;
  if (square.numerator.high < kLeastSquare || square.denominator.high < kLeastSquare)
    return std::nullopt;
  const DoubleDouble d = root_of_quotient(square.numerator, square.denominator);
  double error = square.error + face.error;
  if (!feature.certain) {
    const double largest = reach(face);
    error += 0x1p-96 * largest * (largest / d.high);
  }
  // Both ends of the interval are rounded as its middle.
  if (d.high + (d.low - error) != d.high || d.high + (d.low + error) != d.high) return std::nullopt;
  return d.high;
}

/// The distance of the part that signs of leading doubles are certain of, if they are, unless its
/// last bit is in doubt. Sets the part.
std::optional<double> computed_distance(const Vec3d& p, const Matrix& matrix,
                                        const Vertices& vertices, SeenFace& face,
                                        Feature& feature) {
  if (feature.certain) {
    if (!see_part(p, matrix, vertices, feature, face)) return std::nullopt;
    return rounded_distance(face, feature);
  }
  if (!see(p, matrix, vertices, face)) return std::nullopt;
  feature = nearest_feature(BoundedSigns<double>(face, kSignShare, 0));
  if (!feature.certain)
    feature = nearest_feature(BoundedSigns<DoubleDouble>(face, kFineSignShare, 0));
  return rounded_distance(face, feature);
}

/// Whether all corners certainly lie behind a plane across the way, so far behind it that their
/// distance also rounds to more. `more` is that of see_leading().
bool is_beyond(const SeenFace& face, double more, const NearestKnown& known) {
  constexpr double kLeastDistance = 0x1p-700;  // Products with the way do not underflow
  if (!(known.distance >= kLeastDistance)) return false;
  const Vec3d way_sizes = sizes(known.way, 0);
  const double least = known.distance * std::sqrt(dot(known.way, known.way)) * (1 + 0x1p-49);
  for (const Vec3dd& corner : face.corner) {
    const Vec3d at = high(corner);
    if (!(dot(at, known.way) - 0x1p-50 * dot(sizes(at, more), way_sizes) > least)) return false;
  }
  return true;
}

/// Whether the nearest point and its weights are off by much less than they are rounded by.
bool is_accurate(const Vec3d& p, const SeenFace& face, double thinness, double shortest) {
  double largest = max_norm(p);
  for (const Vec3dd& corner : face.corner) largest = std::max(largest, max_norm(high(corner) + p));
  const double off = spread(face, thinness, shortest);
  return off <= 0x1p-56 * largest && off * thinness <= 0x1p-40 * shortest;
}

std::optional<ClosestPoint> computed_on_edge(const Vec3d& p, const SeenFace& face, std::size_t i) {
  const Vec3dd& edge = face.edge[i];
  if (!is_accurate(p, face, 1, std::sqrt(square(edge)))) return std::nullopt;
  const DoubleDouble t = -(dot(face.corner[i], edge) / dot(edge, edge));
  const Vec3d position = rounded_sum(face.corner[i] + edge * t, p);
  return on_edge(i, std::clamp(t.high, 0.0, 1.0), position);
}

std::optional<ClosestPoint> computed_inside(const Vec3d& p, const SeenFace& face) {
  const Vec3dd normal = cross(face.edge[2], face.edge[0]);
  if (!is_accurate(p, face, thinness(face, normal), shortest_edge(face))) return std::nullopt;
  const DoubleDouble whole = dot(normal, normal);
  const Vec3dd foot = normal * (dot(normal, face.corner[0]) / whole);
  const Vec3dd from_first = foot - face.corner[0];
  const auto weight = [&](const Vec3dd& edge) {
    const DoubleDouble share = dot(cross(edge, from_first), normal) / whole;
    return std::clamp(share.high, 0.0, 1.0);
  };
  return inside(weight(face.edge[2]), weight(face.edge[0]), rounded_sum(foot, p));
}

/// The nearest point, unless its feature is in doubt or it may be off by an ulp.
std::optional<ClosestPoint> computed_point(const Vec3d& p, const Matrix& matrix,
                                           const Vertices& vertices) {
  SeenFace face;
  if (!see(p, matrix, vertices, face)) return std::nullopt;
  const Feature feature =
      nearest_feature(BoundedSigns<double>(face, kSignShare, 0x1p+53 * face.error));
  if (!feature.certain) return std::nullopt;
  if (feature.part == Part::kInside) return computed_inside(p, face);
  if (feature.part == Part::kEdge) return computed_on_edge(p, face, feature.index);
  const std::optional<Vec3d> corner = rounded_corner(matrix, vertices[feature.index]);
  if (!corner) return std::nullopt;
  return on_corner(feature.index, *corner);
}

}  // namespace

double distance(const Vec3d& p, const std::array<double, 12>& world_from_local, const Vec3f& a,
                const Vec3f& b, const Vec3f& c) {
  return DistancesFrom(p, world_from_local).to(a, b, c);
}

DistancesFrom::DistancesFrom(const Vec3d& p, const Matrix& world_from_local)
    : p_(without_smallest(p)),
      matrix_(world_from_local),
      is_plain_(is_identity(matrix_)),
      is_in_range_(is_plain_ || is_in_range(matrix_)) {}

double DistancesFrom::to(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const Vertices vertices = {a, b, c};
  if (is_plain_ && has_nearest(vertices)) return distance_;
  SeenFace face;
  Feature feature;
  // Without a corner or edge that may be the nearest again, all corners are exact at once.
  if (is_in_range_ && (is_plain_ || corners_ > 0)) {
    const double more = see_leading(p_, matrix_, is_plain_, vertices, face);
    if (is_in_range(face)) feature = nearest_feature(BoundedSigns<double>(face, kSignShare, more));
    if (feature.certain && !is_plain_ && is_nearest(vertices, feature)) return distance_;
  }
  const auto computed = computed_distance(p_, matrix_, vertices, face, feature);
  distance_ = computed ? *computed : exact_distance(p_, matrix_, vertices);
  corners_ = 0;
  if (computed && feature.certain && feature.part != Part::kInside) {
    corners_ = feature.part == Part::kCorner ? 1 : 2;
    nearest_ = {vertices[feature.index], vertices[corner_after(feature.index)]};
  }
  return distance_;
}

/// Whether the corner or edge, which certainly is the nearest part, was the nearest before. Under
/// the identity has_nearest() asks this without the other signs, which makes far points a tenth
/// faster.
bool DistancesFrom::is_nearest(const Vertices& vertices, const Feature& feature) const {
  const Vec3f &begin = vertices[feature.index], &end = vertices[corner_after(feature.index)];
  if (feature.part == Part::kCorner) return corners_ == 1 && begin == nearest_[0];
  return feature.part == Part::kEdge && corners_ == 2 &&
         ((begin == nearest_[0] && end == nearest_[1]) ||
          (begin == nearest_[1] && end == nearest_[0]));
}

bool DistancesFrom::approach(const Vec3f& a, const Vec3f& b, const Vec3f& c,
                             NearestKnown& known) const {
  if (!is_in_range_) return true;
  SeenFace face;
  const double more = see_leading(p_, matrix_, is_plain_, {a, b, c}, face);
  if (is_beyond(face, more, known)) return false;
  for (const Vec3dd& corner : face.corner) {
    const Vec3d way = high(corner);
    const double distance = std::sqrt(dot(way, way)) * (1 + 0x1p-50) + 0x1p-52 * more;
    if (distance < known.distance && are_in_range(way, way, way)) known = {distance, way};
  }
  return true;
}

bool DistancesFrom::has_nearest(const Vertices& vertices) const {
  if (corners_ == 0) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    if (corners_ == 1 ? has_corner(vertices, i) : has_edge(vertices, i)) return true;
  }
  return false;
}

namespace {

/// Whether a product of vectors, of which each component is off by at most 4 * 2^-53 of its size,
/// is certainly not negative.
bool is_not_negative(const Vec3d& a, const Vec3d& b, const Vec3d& a_sizes, const Vec3d& b_sizes) {
  const double size = dot(a_sizes, b_sizes);
  return dot(a, b) > kSignShare * size || size == 0;
}
bool is_not_negative(const Vec3d& a, const Vec3d& b) {
  return is_not_negative(a, b, sizes(a, 0), sizes(b, 0));
}

}  // namespace

/// Whether corner i is the one that was nearest, and certainly is the nearest of this face.
bool DistancesFrom::has_corner(const Vertices& vertices, std::size_t i) const {
  if (vertices[i] != nearest_[0]) return false;
  const Vec3d corner(vertices[i]), seen = corner - p_;
  const Vec3d after = Vec3d(vertices[corner_after(i)]) - corner,
              before = Vec3d(vertices[corner_before(i)]) - corner;
  return are_in_range(seen, after, before) && is_not_negative(seen, after) &&
         is_not_negative(seen, before);
}

/// Whether edge i is the one that was nearest, and certainly is the nearest part of this face.
bool DistancesFrom::has_edge(const Vertices& vertices, std::size_t i) const {
  const Vec3f &begin = vertices[i], &end = vertices[corner_after(i)];
  if (!(begin == nearest_[0] && end == nearest_[1]) &&
      !(begin == nearest_[1] && end == nearest_[0]))
    return false;
  const Vec3d from(begin), seen = from - p_, edge = Vec3d(end) - from,
                           other = Vec3d(vertices[corner_before(i)]) - from;
  return are_in_range(seen, edge, other) &&
         is_not_negative(cross(edge, seen), cross(edge, other),
                         cross_sizes(sizes(edge, 0), sizes(seen, 0)),
                         cross_sizes(sizes(edge, 0), sizes(other, 0)));
}

ClosestPoint closest_point(const Vec3d& p, const std::array<double, 12>& world_from_local,
                           const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const Vec3d from = without_smallest(p);
  const Vertices vertices = {a, b, c};
  const std::optional<ClosestPoint> computed = computed_point(from, world_from_local, vertices);
  return computed ? *computed : exact_closest_point(from, world_from_local, vertices);
}

}  // namespace sightline::accel::geometry

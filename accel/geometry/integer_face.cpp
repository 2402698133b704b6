// A face in integers: all coordinates become multiples of one power of two.
#include "accel/geometry/integer_face.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace sightline::accel::geometry {
namespace {

/// mantissa * 2^exponent, the mantissa odd or 0.
struct Scaled {
  std::int64_t mantissa = 0;
  int exponent = 1 << 20;  // Of a 0: above all others, also in a product
};

Scaled scaled(double x) {
  if (x == 0) return {};
  int exponent = 0;
  const auto whole = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
  const int zeros = std::countr_zero(static_cast<std::uint64_t>(whole));
  return {whole / (std::int64_t{1} << zeros), exponent - 53 + zeros};
}

/// The terms of the coordinates of M v and of the point.
struct ScaledFace {
  std::array<Scaled, 12> matrix;
  std::array<std::array<Scaled, 3>, 3> vertices;
  std::array<Scaled, 3> point;

  ScaledFace(const Vec3d& p, const std::array<double, 12>& world_from_local,
             const std::array<Vec3f, 3>& v) {
    for (std::size_t i = 0; i < 12; ++i) matrix[i] = scaled(world_from_local[i]);
    for (std::size_t i = 0; i < 3; ++i) {
      point[i] = scaled(p[i]);
      for (std::size_t j = 0; j < 3; ++j) vertices[i][j] = scaled(static_cast<double>(v[i][j]));
    }
  }

  /// The least exponent of all terms.
  int least_exponent() const {
    int least = Scaled().exponent;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      least = std::min({least, matrix[4 * axis + 3].exponent, point[axis].exponent});
      for (const auto& v : vertices) {
        for (std::size_t j = 0; j < 3; ++j)
          least = std::min(least, matrix[4 * axis + j].exponent + v[j].exponent);
      }
    }
    return least;
  }
};

}  // namespace

IntegerFace integer_face(const Vec3d& p, const std::array<double, 12>& world_from_local,
                         const std::array<Vec3f, 3>& vertices) {
  const ScaledFace scaled(p, world_from_local, vertices);
  IntegerFace face;
  face.exponent = scaled.least_exponent();
  const auto whole = [&](const Scaled& a) {
    return a.mantissa == 0 ? Integer() : shifted(a.mantissa, a.exponent - face.exponent);
  };
  const auto product = [&](const Scaled& a, const Scaled& b) {
    if (a.mantissa == 0 || b.mantissa == 0) return Integer();
    return shifted(Integer(a.mantissa) * b.mantissa, a.exponent + b.exponent - face.exponent);
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    face.point[axis] = whole(scaled.point[axis]);
    const Integer moved = whole(scaled.matrix[4 * axis + 3]) - face.point[axis];
    for (std::size_t i = 0; i < 3; ++i) {
      Integer& sum = face.corner[i][axis];
      sum = moved;
      for (std::size_t j = 0; j < 3; ++j)
        sum += product(scaled.matrix[4 * axis + j], scaled.vertices[i][j]);
    }
  }
  for (std::size_t i = 0; i < 3; ++i) face.edge[i] = face.corner[corner_after(i)] - face.corner[i];
  face.normal = cross(face.edge[2], face.edge[0]);
  return face;
}

IntegerFoot foot_of(const IntegerFace& face, const Feature& nearest) {
  const IntegerVec& from = face.corner[nearest.index];
  if (nearest.part == Part::kCorner) return {from};
  if (nearest.part == Part::kEdge) {
    const IntegerVec& edge = face.edge[nearest.index];
    const Integer whole = dot(edge, edge);
    return {from * whole - edge * Integer(dot(from, edge)), whole};
  }
  return {face.normal * Integer(dot(face.normal, from)), dot(face.normal, face.normal)};
}

}  // namespace sightline::accel::geometry

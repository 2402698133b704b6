// The distance rule in integers: all coordinates are multiples of one power of two.
#include "accel/geometry/closest_exact.h"

#include <algorithm>
#include <bit>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstdint>
#include <limits>

#include "accel/geometry/closest_feature.h"

namespace sightline::accel::geometry {
namespace {

// Most numbers have fewer bits than this and need no allocation.
using Integer = boost::multiprecision::number<boost::multiprecision::cpp_int_backend<768>,
                                              boost::multiprecision::et_off>;
using IntegerVec = Vec3<Integer>;

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

/// x 2^k; k >= 0.
Integer shifted(Integer x, int k) {
  x <<= static_cast<unsigned>(k);
  return x;
}

/// The face as seen from the point: corners minus the point. In units of 2^exponent.
struct IntegerFace {
  std::array<IntegerVec, 3> corner, edge;
  IntegerVec normal;
  IntegerVec point;
  int exponent = 0;
};

IntegerFace integer_face(const ScaledFace& scaled) {
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

class IntegerSigns {
 public:
  explicit IntegerSigns(const IntegerFace& face) : face_(face) {}

  Sign along(std::size_t corner, std::size_t edge) const {
    return {dot(face_.corner[corner], face_.edge[edge]).sign()};
  }
  Sign side(std::size_t i) const {
    return {dot(cross(face_.edge[i], face_.corner[i]), face_.normal).sign()};
  }
  bool has_length(std::size_t i) const { return dot(face_.edge[i], face_.edge[i]) != 0; }

 private:
  const IntegerFace& face_;
};

/// (whole + rest) * 2^exponent rounded to double, with whole in [2^60, 2^63), 0 <= rest < 1, and
/// rest > 0 if `more`.
double rounded(std::uint64_t whole, bool more, std::int64_t exponent) {
  const auto width = static_cast<int>(std::bit_width(whole));
  // The unit of the result's last bit: that of the smallest doubles at least.
  const std::int64_t unit = std::max<std::int64_t>(exponent + width - 53, -1074);
  const std::int64_t cut = unit - exponent;
  if (cut > width) return 0;
  const std::uint64_t half = std::uint64_t{1} << (cut - 1);
  const std::uint64_t rest = whole & (2 * half - 1);
  std::uint64_t kept = whole >> cut;
  if (rest > half || (rest == half && (more || kept % 2 != 0))) ++kept;
  return std::ldexp(static_cast<double>(kept), static_cast<int>(unit));
}

/// How far n is shifted so that n / d has k or k + 1 bits.
int shift_to_bits(const Integer& n, const Integer& d, int k) {
  return k - (static_cast<int>(msb(n)) - static_cast<int>(msb(d)));
}

/// n 2^k / d as a whole number; `more` tells whether there is a rest.
Integer quotient(const Integer& n, const Integer& d, int k, bool& more) {
  Integer whole, rest;
  divide_qr(k > 0 ? shifted(n, k) : n, k < 0 ? shifted(d, -k) : d, whole, rest);
  more = rest != 0;
  return whole;
}

/// n / d * 2^exponent; d > 0.
double rounded_quotient(const Integer& n, const Integer& d, int exponent) {
  if (n == 0) return 0;
  const Integer size = abs(n);
  const int k = shift_to_bits(size, d, 62);
  bool more = false;
  const Integer whole = quotient(size, d, k, more);
  const double value = rounded(static_cast<std::uint64_t>(whole), more, std::int64_t{exponent} - k);
  return (n < 0 ? -value : value) + 0.0;  // No negative zero
}

/// The root of n / d, times 2^exponent; n >= 0, d > 0.
double rounded_root(const Integer& n, const Integer& d, int exponent) {
  if (n == 0) return 0;
  __extension__ using Wide = unsigned __int128;
  int k = shift_to_bits(n, d, 122);
  if (k % 2 != 0) ++k;
  bool more = false;
  const Integer whole = quotient(n, d, k, more);
  const Wide square = (Wide{static_cast<std::uint64_t>(whole >> 64)} << 64) |
                      static_cast<std::uint64_t>(whole & std::numeric_limits<std::uint64_t>::max());
  // The square is between 2^121 and 2^124. A root in double is off by 2^10, and Newton's step by 1.
  auto root = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(square)));
  root = static_cast<std::uint64_t>((root + square / root) / 2);
  while (Wide{root} * root > square) --root;
  while (Wide{root + 1} * (root + 1) <= square) ++root;
  more = more || Wide{root} * root != square;
  return rounded(root, more, std::int64_t{exponent} - k / 2);
}

}  // namespace

double exact_distance(const Vec3d& p, const std::array<double, 12>& world_from_local,
                      const std::array<Vec3f, 3>& vertices) {
  const IntegerFace face = integer_face({p, world_from_local, vertices});
  const Feature feature = nearest_feature(IntegerSigns(face));
  const IntegerVec& from = face.corner[feature.index];
  if (feature.part == Part::kCorner) return rounded_root(dot(from, from), 1, face.exponent);
  if (feature.part == Part::kEdge) {
    const IntegerVec& edge = face.edge[feature.index];
    const IntegerVec moment = cross(edge, from);
    return rounded_root(dot(moment, moment), dot(edge, edge), face.exponent);
  }
  const Integer height = dot(face.normal, from);
  return rounded_root(height * height, dot(face.normal, face.normal), face.exponent);
}

ClosestPoint exact_closest_point(const Vec3d& p, const std::array<double, 12>& world_from_local,
                                 const std::array<Vec3f, 3>& vertices) {
  const IntegerFace face = integer_face({p, world_from_local, vertices});
  const Feature feature = nearest_feature(IntegerSigns(face));
  const IntegerVec& from = face.corner[feature.index];
  ClosestPoint result;
  IntegerVec seen = from;  // Seen from the point, in units of 2^exponent / whole
  Integer whole = 1;
  if (feature.part == Part::kCorner) {
    result = on_corner(feature.index, {});
  } else if (feature.part == Part::kEdge) {
    const IntegerVec& edge = face.edge[feature.index];
    const Integer along = -dot(from, edge);
    whole = dot(edge, edge);
    seen = from * whole + edge * along;
    result = on_edge(feature.index, rounded_quotient(along, whole, 0), {});
  } else {
    whole = dot(face.normal, face.normal);
    seen = face.normal * Integer(dot(face.normal, from));
    const IntegerVec on_face = seen - from * whole;
    const auto weight = [&](std::size_t i) {
      return rounded_quotient(dot(cross(face.edge[i], on_face), face.normal), whole * whole, 0);
    };
    result = inside(weight(2), weight(0), {});
  }
  const IntegerVec position = seen + face.point * whole;
  for (std::size_t axis = 0; axis < 3; ++axis)
    result.position[axis] = rounded_quotient(position[axis], whole, face.exponent);
  return result;
}

}  // namespace sightline::accel::geometry

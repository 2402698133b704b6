// The distance rule in integers: quotients of them and their roots, rounded once.
#include "accel/geometry/closest_exact.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "accel/geometry/closest_feature.h"
#include "accel/geometry/integer_face.h"

namespace sightline::accel::geometry {
namespace {

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
  const IntegerFace face = integer_face(p, world_from_local, vertices);
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
  const IntegerFace face = integer_face(p, world_from_local, vertices);
  const Feature feature = nearest_feature(IntegerSigns(face));
  const IntegerFoot foot = foot_of(face, feature);
  ClosestPoint result;
  if (feature.part == Part::kCorner) {
    result = on_corner(feature.index, {});
  } else if (feature.part == Part::kEdge) {
    const Integer along = -dot(face.corner[feature.index], face.edge[feature.index]);
    result = on_edge(feature.index, rounded_quotient(along, foot.whole, 0), {});
  } else {
    const IntegerVec on_face = foot.seen - face.corner[0] * foot.whole;
    const auto weight = [&](std::size_t i) {
      return rounded_quotient(dot(cross(face.edge[i], on_face), face.normal),
                              foot.whole * foot.whole, 0);
    };
    result = inside(weight(2), weight(0), {});
  }
  const IntegerVec position = foot.seen + face.point * foot.whole;
  for (std::size_t axis = 0; axis < 3; ++axis)
    result.position[axis] = rounded_quotient(position[axis], foot.whole, face.exponent);
  return result;
}

}  // namespace sightline::accel::geometry

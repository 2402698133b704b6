// Faces and their nearest points in integers, of which the leading 106 bits are kept in the end.
#include <algorithm>
#include <cmath>

#include "accel/geometry/closest_errors.h"
#include "accel/geometry/closest_exact.h"
#include "accel/geometry/integer_face.h"
#include "accel/geometry/pseudonormal.h"

namespace sightline::accel::geometry {
namespace {

/// Numbers times 2^exponent; the largest has 106 bits, or is 0.
struct LeadingBits {
  Vec3dd value;
  int exponent = 0;
};

DoubleDouble as_sum(const Integer& n) {
  const auto high = static_cast<double>(n);
  return quick_two_sum(high, static_cast<double>(Integer(n - Integer(high))));
}

LeadingBits leading_bits(const IntegerVec& v) {
  const Integer largest = std::max({Integer(abs(v.x)), Integer(abs(v.y)), Integer(abs(v.z))});
  if (largest == 0) return {};
  LeadingBits bits;
  bits.exponent = static_cast<int>(msb(largest)) - 105;
  const auto shift = static_cast<unsigned>(std::abs(bits.exponent));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Integer size = abs(v[axis]);
    const DoubleDouble kept =
        as_sum(bits.exponent > 0 ? Integer(size >> shift) : Integer(size << shift));
    bits.value[axis] = v[axis] < 0 ? -kept : kept;
  }
  return bits;
}

DoubleDouble scaled_by(const DoubleDouble& x, int exponent) {
  return {std::ldexp(x.high, exponent), std::ldexp(x.low, exponent)};
}
Vec3dd scaled_by(const Vec3dd& v, int exponent) {
  return {scaled_by(v.x, exponent), scaled_by(v.y, exponent), scaled_by(v.z, exponent)};
}

SeenFace seen_face(const IntegerFace& exact) {
  const auto rounded = [&](const IntegerVec& v) {
    const LeadingBits bits = leading_bits(v);
    return scaled_by(bits.value, bits.exponent + exact.exponent);
  };
  SeenFace face;
  for (std::size_t i = 0; i < 3; ++i) {
    face.corner[i] = rounded(exact.corner[i]);
    face.edge[i] = rounded(exact.edge[i]);
  }
  face.error = 0x1p-103 * reach(face);
  return face;
}

}  // namespace

FaceNormal exact_normal(const Vec3d& p, const std::array<double, 12>& world_from_local,
                        const std::array<Vec3f, 3>& vertices) {
  const IntegerFace exact = integer_face(without_smallest(p), world_from_local, vertices);
  FaceNormal face{seen_face(exact), {}, {}};
  const LeadingBits normal = leading_bits(exact.normal);
  const DoubleDouble square = dot(normal.value, normal.value);
  if (square.high == 0) return face;
  face.normal = normal.value * root_of_quotient({1, 0}, square);
  face.area = scaled_by(root_of_quotient(square, {1, 0}), normal.exponent + 2 * exact.exponent);
  return face;
}

NearestPoint exact_nearest(const Vec3d& p, const std::array<double, 12>& world_from_local,
                           const std::array<Vec3f, 3>& vertices, double distance) {
  const Vec3d from = without_smallest(p);
  const IntegerFace exact = integer_face(from, world_from_local, vertices);
  NearestPoint nearest;
  nearest.feature = nearest_feature(IntegerSigns(exact));
  nearest.position = exact_closest_point(from, world_from_local, vertices).position;
  const IntegerFoot foot = foot_of(exact, nearest.feature);
  const LeadingBits seen = leading_bits(foot.seen), whole = leading_bits({foot.whole, 0, 0});
  const int exponent = seen.exponent - whole.exponent + exact.exponent;
  Vec3dd quotient;
  for (std::size_t axis = 0; axis < 3; ++axis) quotient[axis] = seen.value[axis] / whole.value.x;
  nearest.from_p = scaled_by(quotient, exponent - std::ilogb(distance));
  set_view(from, scaled_by(quotient, exponent), 0x1p-98 * distance, reach(seen_face(exact)),
           longest_edge(world_from_local, vertices), nearest);
  return nearest;
}

}  // namespace sightline::accel::geometry

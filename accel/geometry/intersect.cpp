// The hit rule: signs are computed in doubles with a proven error bound, in double doubles where
// that does not decide, and exactly where neither does.
#include "accel/geometry/intersect.h"

#include <algorithm>
#include <array>
#include <limits>

#include "accel/geometry/double_double.h"
#include "accel/geometry/exact_sum.h"

namespace sightline::accel::geometry {
namespace {

std::array<ExactSum, 3> difference(const Vec3d& a, const Vec3d& b) {
  return {ExactSum::difference(a.x, b.x), ExactSum::difference(a.y, b.y),
          ExactSum::difference(a.z, b.z)};
}

std::array<ExactSum, 3> cross(const std::array<ExactSum, 3>& p, const std::array<ExactSum, 3>& q) {
  std::array<ExactSum, 3> result;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    result[i].add_product(p[j], q[k]);
    ExactSum minus;
    minus.add_product(p[k], q[j]);
    result[i].subtract(minus);
  }
  return result;
}

ExactSum dot(const std::array<ExactSum, 3>& p, const std::array<ExactSum, 3>& q) {
  ExactSum sum;
  for (std::size_t i = 0; i < 3; ++i) sum.add_product(p[i], q[i]);
  return sum;
}

std::array<ExactSum, 3> exactly(const Vec3d& v) {
  return {ExactSum(v.x), ExactSum(v.y), ExactSum(v.z)};
}

/// Sign of det[d, a - o, b - o] for the ray with its origin moved by (e, e^2, e^3): the determinant
/// is linear in the origin with gradient (a - b) x d, so the first non-zero of (det, gradient x, y,
/// z) decides. 0 only for an edge parallel to the ray or of no length, and then the triangle is
/// edge-on. The determinant is computed as det[d, a - o, b - a], which is equal and has far fewer
/// terms: a difference of floats mostly is one double.
int exact_sign(const LocalRay& ray, const Vec3d& a, const Vec3d& b) {
  const auto d = exactly(ray.direction);
  const int sign = dot(d, cross(difference(a, ray.origin), difference(b, a))).sign();
  if (sign != 0) return sign;
  const auto gradient = cross(difference(a, b), d);
  for (const ExactSum& component : gradient) {
    if (component.sign() != 0) return component.sign();
  }
  return 0;
}

/// det[d, a - o, b - a]. Both differences are exact, and no product is below 2^-760. In units of
/// 2^-106 |a - o| |b - a| (maximum norm), a component of the cross product is off by at most 24,
/// its product with |d| < 2 by 80, and the sum of three such products by 336.
DoubleDouble determinant_in_double_doubles(const LocalRay& ray, const Vec3d& a, const Vec3d& b) {
  std::array<DoubleDouble, 3> p, e;
  for (std::size_t i = 0; i < 3; ++i) {
    p[i] = two_sum(a[i], -ray.origin[i]);
    e[i] = two_sum(b[i], -a[i]);
  }
  DoubleDouble sum;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    sum = sum + DoubleDouble{ray.direction[i]} * (p[j] * e[k] - p[k] * e[j]);
  }
  return sum;
}

int edge_sign(const LocalRay& ray, const Vec3d& a, const Vec3d& b, double determinant,
              double bound) {
  if (determinant > bound) return 1;
  if (determinant < -bound) return -1;
  const double fine = determinant_in_double_doubles(ray, a, b).high;
  // More than 336 * 2^-106.
  if (std::fabs(fine) > 0x1p-97 * max_norm(a - ray.origin) * max_norm(b - a))
    return fine > 0 ? 1 : -1;
  return exact_sign(ray, a, b);
}

/// t = N . (a - o) / N . d for a triangle so nearly edge-on, or so thin, that doubles lose it.
double exact_t(const LocalRay& ray, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const auto normal = cross(difference(b, a), difference(c, a));
  return dot(normal, difference(a, ray.origin)).estimate() /
         dot(normal, exactly(ray.direction)).estimate();
}

/// det[d, c - o, a - o] and det[d, a - o, b - o] divided by N . d, computed exactly.
Barycentric exact_weights(const LocalRay& ray, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const auto d = exactly(ray.direction);
  const auto pa = difference(a, ray.origin), pb = difference(b, ray.origin),
             pc = difference(c, ray.origin);
  const double whole = dot(cross(difference(b, a), difference(c, a)), d).estimate();
  return {dot(d, cross(pc, pa)).estimate() / whole, dot(d, cross(pa, pb)).estimate() / whole};
}

}  // namespace

double intersect_survivor(const LocalRay& ray, const Vec3f& af, const Vec3f& bf, const Vec3f& cf,
                          const Vec3d& determinants) {
  const Vec3d a(af), b(bf), c(cf);
  const Vec3d pa = a - ray.origin, pb = b - ray.origin, pc = c - ray.origin;
  const double na = max_norm(pa), nb = max_norm(pb), nc = max_norm(pc);
  const auto& [ab, bc, ca] = determinants;
  constexpr double kMiss = std::numeric_limits<double>::quiet_NaN();
  const int sign = edge_sign(ray, a, b, ab, kSignError * na * nb);
  if (sign == 0 || edge_sign(ray, b, c, bc, kSignError * nb * nc) != sign ||
      edge_sign(ray, c, a, ca, kSignError * nc * na) != sign) {
    return kMiss;
  }
  const Vec3d e1 = b - a, e2 = c - a;
  const Vec3d normal = cross(e1, e2);
  const double denominator = dot(normal, ray.direction);
  if (std::fabs(denominator) < kEdgeOn * max_norm(e1) * max_norm(e2))
    return exact_t(ray, a, b, c) + 0.0;
  return dot(normal, pa) / denominator + 0.0;  // + 0.0: no negative zero
}

bool is_ahead(const LocalRay& ray, double t, const Vec3f& af, const Vec3f& bf, const Vec3f& cf) {
  const Vec3d a(af), b(bf), c(cf);
  const Vec3d pa = a - ray.origin, pb = b - ray.origin, pc = c - ray.origin;
  // The factor covers the rounding of the differences.
  const double off = 1.01 * kHitError * std::max({max_norm(pa), max_norm(pb), max_norm(pc)});
  if (t > off) return true;
  if (t < -off) return false;
  const auto normal = cross(difference(b, a), difference(c, a));
  const bool faces_along = dot(normal, exactly(ray.direction)).sign() > 0;
  const int height = dot(normal, difference(a, ray.origin)).sign();
  if (height != 0) return (height > 0) == faces_along;
  // N . (a - o(e)) is then -N . (e, e^2, e^3).
  for (const ExactSum& component : normal) {
    if (component.sign() != 0) return (component.sign() < 0) == faces_along;
  }
  return false;
}

Barycentric barycentric(const LocalRay& ray, double t, const Vec3f& af, const Vec3f& bf,
                        const Vec3f& cf) {
  const Vec3d a(af), b(bf), c(cf);
  // Relative to the hit point, coordinates are as large as the triangle, not as the ray's length.
  // The origin is subtracted first, so that the distance from the frame's zero does not matter
  // either.
  const Vec3d p = ray.direction * t;
  const Vec3d pa = (a - ray.origin) - p, pb = (b - ray.origin) - p, pc = (c - ray.origin) - p;
  const double wa = dot(ray.direction, cross(pb, pc));
  const double wb = dot(ray.direction, cross(pc, pa));
  const double wc = dot(ray.direction, cross(pa, pb));
  const double sum = wa + wb + wc;
  // Each of the three is wrong by 2^-46 size^2 at most, as in the hit rule: a quotient by 2^-28.
  const double size = std::max({max_norm(pa), max_norm(pb), max_norm(pc)});
  const Barycentric weights = std::fabs(sum) <= kEdgeOn * size * size
                                  ? exact_weights(ray, a, b, c)
                                  : Barycentric{wb / sum, wc / sum};
  const double u = std::clamp(weights.u, 0.0, 1.0) + 0.0;  // no negative zero
  const double v = std::clamp(weights.v, 0.0, 1.0) + 0.0;
  if (u + v <= 1) return {u, v};
  const double share = u / (u + v);
  return {share, 1 - share};  // two rounded quotients can add up to more than 1
}

}  // namespace sightline::accel::geometry

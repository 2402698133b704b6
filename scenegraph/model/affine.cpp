// Composition and inversion of affine transforms.
#include "scenegraph/model/affine.h"

#include <algorithm>
#include <cmath>

#include "accel/geometry/exact_sum.h"

namespace sightline::scenegraph::model {
namespace {

using accel::geometry::ExactSum;

/// Up to this condition the rounding of the plain formula is in proportion to the condition; the
/// determinant may lose its square.
constexpr double kMostPlain = 16;

/// The cross product, rounded once or twice.
Vec3d exact_cross(const Vec3d& a, const Vec3d& b) {
  const auto minor = [](double x, double y, double z, double w) {
    ExactSum sum;
    sum.add_product(x, y);
    sum.add_product(-z, w);
    return sum.estimate();
  };
  return {minor(a.y, b.z, a.z, b.y), minor(a.z, b.x, a.x, b.z), minor(a.x, b.y, a.y, b.x)};
}

double exact_determinant(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  ExactSum sum;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    sum.add_product(ExactSum(a[i]), ExactSum(b[j]), ExactSum(c[k]));
    sum.add_product(ExactSum(-a[i]), ExactSum(b[k]), ExactSum(c[j]));
  }
  return sum.estimate();
}

/// The inverse with these rows of the linear part, cofactors and determinant.
Affine inverse_of(const Affine& a, const std::array<Vec3d, 3>& c, double determinant) {
  const double s = 1 / determinant;
  Affine r;
  r.m = {c[0].x * s, c[1].x * s, c[2].x * s, 0,          c[0].y * s, c[1].y * s,
         c[2].y * s, 0,          c[0].z * s, c[1].z * s, c[2].z * s, 0};
  const Vec3d t = r.direction({a.m[3], a.m[7], a.m[11]});
  r.m[3] = -t.x;
  r.m[7] = -t.y;
  r.m[11] = -t.z;
  return r;
}

}  // namespace

Affine compose(const Affine& outer, const Affine& inner) {
  Affine r;
  for (std::size_t row = 0; row < 3; ++row) {
    const double* o = &outer.m[4 * row];
    for (std::size_t col = 0; col < 4; ++col) {
      r.m[4 * row + col] = o[0] * inner.m[col] + o[1] * inner.m[4 + col] + o[2] * inner.m[8 + col];
    }
    r.m[4 * row + 3] += o[3];
  }
  return r;
}

bool is_finite(const Affine& a) {
  return std::ranges::all_of(a.m, [](double x) { return std::isfinite(x); });
}

std::optional<Affine> inverse(const Affine& a) {
  const auto& m = a.m;
  if (!is_finite(a)) return std::nullopt;
  const Vec3d r0{m[0], m[1], m[2]}, r1{m[4], m[5], m[6]}, r2{m[8], m[9], m[10]};
  const std::array c{cross(r1, r2), cross(r2, r0), cross(r0, r1)};
  const double determinant = dot(r0, c[0]);
  if (determinant == 0 || !std::isfinite(determinant)) return std::nullopt;
  Affine r = inverse_of(a, c, determinant);
  if (is_finite(r) && condition(a, r) > kMostPlain) {
    const double exact = exact_determinant(r0, r1, r2);
    if (exact == 0) return std::nullopt;
    r = inverse_of(a, {exact_cross(r1, r2), exact_cross(r2, r0), exact_cross(r0, r1)}, exact);
  }
  if (!is_finite(r) || !(condition(a, r) <= kMaxCondition)) return std::nullopt;
  return r;
}

double condition(const Affine& a, const Affine& inverse_of_a) {
  const auto norm = [](const Affine& x) {
    double sum = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t col = 0; col < 3; ++col) sum += x.m[4 * row + col] * x.m[4 * row + col];
    }
    return std::sqrt(sum);
  };
  return norm(a) * norm(inverse_of_a);
}

}  // namespace sightline::scenegraph::model

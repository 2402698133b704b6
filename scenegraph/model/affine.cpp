// Composition and inversion of affine transforms.
#include "scenegraph/model/affine.h"

#include <algorithm>
#include <cmath>

namespace sightline::scenegraph::model {

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
  const Vec3d c0 = cross(r1, r2), c1 = cross(r2, r0), c2 = cross(r0, r1);
  const double determinant = dot(r0, c0);
  if (determinant == 0 || !std::isfinite(determinant)) return std::nullopt;
  const double s = 1 / determinant;
  Affine r;
  r.m = {c0.x * s, c1.x * s, c2.x * s, 0,        c0.y * s, c1.y * s,
         c2.y * s, 0,        c0.z * s, c1.z * s, c2.z * s, 0};
  const Vec3d t = r.direction({m[3], m[7], m[11]});
  r.m[3] = -t.x;
  r.m[7] = -t.y;
  r.m[11] = -t.z;
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

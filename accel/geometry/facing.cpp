// The sign of a determinant: in doubles with a proven error bound, exactly where that does not
// decide.
#include "accel/geometry/facing.h"

#include "accel/geometry/exact_sum.h"
#include "accel/geometry/intersect.h"

namespace sightline::accel::geometry {
namespace {

int exact_facing(const LocalRay& ray, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  ExactSum plus, minus;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const ExactSum d(ray.direction[i]);
    plus.add_product(ExactSum::difference(b[j], a[j]), ExactSum::difference(c[k], a[k]), d);
    minus.add_product(ExactSum::difference(b[k], a[k]), ExactSum::difference(c[j], a[j]), d);
  }
  plus.subtract(minus);
  return plus.sign();
}

}  // namespace

int facing(const LocalRay& ray, const Vec3f& af, const Vec3f& bf, const Vec3f& cf) {
  const Vec3d a(af), b(bf), c(cf);
  const Vec3d e1 = b - a, e2 = c - a;
  const double along = dot(cross(e1, e2), ray.direction);
  // The bound is that of the hit rule: there are six terms, each at most |d| |e1| |e2|.
  const double bound = kSignError * max_norm(e1) * max_norm(e2);
  if (along > bound) return 1;
  if (along < -bound) return -1;
  return exact_facing(ray, a, b, c);
}

}  // namespace sightline::accel::geometry

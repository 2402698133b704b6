// Clipping a triangle to a box, one face after the other. Source: Sutherland, Hodgman 1974.
#include "accel/geometry/clip.h"

#include <algorithm>
#include <array>

namespace sightline::accel {
namespace {

/// Six cuts add at most one corner each to three.
struct Polygon {
  std::array<Vec3d, 9> at;
  std::size_t size = 0;
};

/// Keeps the part with sign * (x[axis] - position) <= 0.
Polygon cut(const Polygon& in, std::size_t axis, double sign, double position) {
  Polygon out;
  for (std::size_t i = 0; i < in.size; ++i) {
    const Vec3d& p = in.at[i];
    const Vec3d& q = in.at[i + 1 == in.size ? 0 : i + 1];
    const double dp = sign * (p[axis] - position), dq = sign * (q[axis] - position);
    if (dp <= 0) out.at[out.size++] = p;
    if ((dp < 0 && dq > 0) || (dp > 0 && dq < 0)) {
      Vec3d x = p + (q - p) * (dp / (dp - dq));
      x[axis] = position;
      out.at[out.size++] = x;
    }
  }
  return out;
}

}  // namespace

std::optional<Aabb> clipped_bounds(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Aabb& cell) {
  Polygon polygon;
  polygon.at[0] = Vec3d(a);
  polygon.at[1] = Vec3d(b);
  polygon.at[2] = Vec3d(c);
  polygon.size = 3;
  // The corners that cutting makes are off by a few roundings of the largest coordinate: cutting a little outside the
  // cell, and widening what comes out by as much, keeps every true point.
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) largest = std::max(largest, std::fabs(polygon.at[i][k]));
  }
  const double slack = largest * 0x1p-48;
  for (std::size_t axis = 0; axis < 3 && polygon.size > 0; ++axis) {
    polygon = cut(polygon, axis, -1, static_cast<double>(cell.lo[axis]) - slack);
    polygon = cut(polygon, axis, 1, static_cast<double>(cell.hi[axis]) + slack);
  }
  if (polygon.size == 0) return std::nullopt;
  Aabb box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double lo = polygon.at[0][axis], hi = lo;
    for (std::size_t i = 1; i < polygon.size; ++i) {
      lo = std::min(lo, polygon.at[i][axis]);
      hi = std::max(hi, polygon.at[i][axis]);
    }
    // A vertex of the triangle is exact; what was cut is not.
    const double whole_lo = static_cast<double>(std::min({a[axis], b[axis], c[axis]}));
    const double whole_hi = static_cast<double>(std::max({a[axis], b[axis], c[axis]}));
    box.lo[axis] = std::max(lo == whole_lo ? round_down(lo) : round_down(lo - slack), cell.lo[axis]);
    box.hi[axis] = std::min(hi == whole_hi ? round_up(hi) : round_up(hi + slack), cell.hi[axis]);
    if (box.lo[axis] > box.hi[axis]) return std::nullopt;
  }
  return widen_flat(box);
}

}  // namespace sightline::accel

// Clips a triangle to a box, one face after the other. Source: Sutherland, Hodgman 1974.
#include "accel/geometry/clip.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace sightline::accel::geometry {
namespace {

/// A corner is not initialised, unlike Vec3d: clearing two polygons would take a tenth of the time.
using Corner = std::array<double, 3>;

/// A triangle has three corners, and each of six cuts adds at most one.
struct Polygon {
  std::array<Corner, 9> at;
  std::size_t size;
};

/// Keeps the part with sign * (x[axis] - position) <= 0. Returns false, and leaves `out` unset, if
/// that is the whole polygon.
bool cut(const Polygon& in, std::size_t axis, double sign, double position, Polygon& out) {
  std::array<double, 9> beyond;
  bool cuts = false;
  for (std::size_t i = 0; i < in.size; ++i) {
    beyond[i] = sign * (in.at[i][axis] - position);
    cuts |= beyond[i] > 0;
  }
  if (!cuts) return false;
  out.size = 0;
  for (std::size_t i = 0; i < in.size; ++i) {
    const std::size_t j = i + 1 == in.size ? 0 : i + 1;
    const double dp = beyond[i], dq = beyond[j];
    const Corner &p = in.at[i], &q = in.at[j];
    if (dp <= 0) out.at[out.size++] = p;
    if ((dp < 0 && dq > 0) || (dp > 0 && dq < 0)) {
      Corner& x = out.at[out.size++];
      const double share = dp / (dp - dq);
      for (std::size_t k = 0; k < 3; ++k) x[k] = p[k] + (q[k] - p[k]) * share;
      x[axis] = position;
    }
  }
  return true;
}

void set_triangle(const Vec3f& a, const Vec3f& b, const Vec3f& c, Polygon& out) {
  out.size = 0;
  for (const Vec3f* v : {&a, &b, &c}) {
    out.at[out.size++] = {static_cast<double>(v->x), static_cast<double>(v->y),
                          static_cast<double>(v->z)};
  }
}

}  // namespace

std::optional<Aabb> clipped_bounds(const Vec3f& a, const Vec3f& b, const Vec3f& c,
                                   const Aabb& cell) {
  std::array<Polygon, 2> polygons;  // input and output of a cut, in turn
  std::size_t now = 0;
  set_triangle(a, b, c, polygons[0]);
  // New corners are off by a few roundings of the largest coordinate. Cutting slightly outside the
  // cell, and widening the result by as much, keeps every true point.
  Vec3d whole_lo, whole_hi;
  double largest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    whole_lo[axis] = static_cast<double>(std::min({a[axis], b[axis], c[axis]}));
    whole_hi[axis] = static_cast<double>(std::max({a[axis], b[axis], c[axis]}));
    largest = std::max({largest, -whole_lo[axis], whole_hi[axis]});
  }
  const double slack = largest * 0x1p-48;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // A face of the cell that the triangle does not cross needs no cut.
    const double lo = static_cast<double>(cell.lo[axis]) - slack,
                 hi = static_cast<double>(cell.hi[axis]) + slack;
    if (whole_lo[axis] < lo && cut(polygons[now], axis, -1, lo, polygons[1 - now])) now = 1 - now;
    if (whole_hi[axis] > hi && cut(polygons[now], axis, 1, hi, polygons[1 - now])) now = 1 - now;
  }
  const Polygon& polygon = polygons[now];
  if (polygon.size == 0) return std::nullopt;
  Aabb box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double lo = polygon.at[0][axis], hi = lo;
    for (std::size_t i = 1; i < polygon.size; ++i) {
      lo = std::min(lo, polygon.at[i][axis]);
      hi = std::max(hi, polygon.at[i][axis]);
    }
    // The result is widened, but not beyond the bounds of the triangle, which are exact.
    box.lo[axis] = std::max(round_down(std::max(lo - slack, whole_lo[axis])), cell.lo[axis]);
    box.hi[axis] = std::min(round_up(std::min(hi + slack, whole_hi[axis])), cell.hi[axis]);
    if (box.lo[axis] > box.hi[axis]) return std::nullopt;
  }
  return widen_flat(box);
}

}  // namespace sightline::accel::geometry

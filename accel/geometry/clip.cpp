// Clipping a triangle to a box, one face after the other. Source: Sutherland, Hodgman 1974.
#include "accel/geometry/clip.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sightline::accel {
namespace {

/// Six cuts add at most one corner each to three.
struct Polygon {
  std::array<Vec3d, 9> at;
  std::size_t size = 0;
};

/// Keeps the part with sign * (x[axis] - position) <= 0.
void cut(const Polygon& in, std::size_t axis, double sign, double position, Polygon& out) {
  out.size = 0;
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
}

Polygon triangle(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  Polygon polygon;
  polygon.at[0] = Vec3d(a);
  polygon.at[1] = Vec3d(b);
  polygon.at[2] = Vec3d(c);
  polygon.size = 3;
  return polygon;
}

}  // namespace

double clipped_area(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Aabb& cell) {
  std::array<Polygon, 2> polygons{triangle(a, b, c), {}};
  std::size_t now = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double lo = static_cast<double>(cell.lo[axis]), hi = static_cast<double>(cell.hi[axis]);
    cut(polygons[now], axis, -1, lo, polygons[1 - now]);
    cut(polygons[1 - now], axis, 1, hi, polygons[now]);
    if (polygons[now].size < 3) return 0;
  }
  const Polygon& polygon = polygons[now];
  Vec3d twice{0, 0, 0};
  for (std::size_t i = 1; i + 1 < polygon.size; ++i) {
    twice = twice + cross(polygon.at[i] - polygon.at[0], polygon.at[i + 1] - polygon.at[0]);
  }
  return std::sqrt(dot(twice, twice)) / 2;
}

std::optional<Aabb> clipped_bounds(const Vec3f& a, const Vec3f& b, const Vec3f& c,
                                   const Aabb& cell) {
  std::array<Polygon, 2> polygons;  // what is cut, and what comes of it, in turn
  std::size_t now = 0;
  polygons[0] = triangle(a, b, c);
  // The corners that cutting makes are off by a few roundings of the largest coordinate: cutting a
  // little outside the cell, and widening what comes out by as much, keeps every true point.
  Vec3d whole_lo, whole_hi;
  double largest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    whole_lo[axis] = static_cast<double>(std::min({a[axis], b[axis], c[axis]}));
    whole_hi[axis] = static_cast<double>(std::max({a[axis], b[axis], c[axis]}));
    largest = std::max({largest, -whole_lo[axis], whole_hi[axis]});
  }
  const double slack = largest * 0x1p-48;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // A face that the triangle does not reach beyond cuts nothing off.
    const double lo = static_cast<double>(cell.lo[axis]) - slack,
                 hi = static_cast<double>(cell.hi[axis]) + slack;
    if (whole_lo[axis] < lo) {
      cut(polygons[now], axis, -1, lo, polygons[1 - now]);
      now = 1 - now;
    }
    if (whole_hi[axis] > hi) {
      cut(polygons[now], axis, 1, hi, polygons[1 - now]);
      now = 1 - now;
    }
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
    // What was cut is widened, but never beyond the triangle, whose own bounds are exact.
    box.lo[axis] = std::max(round_down(std::max(lo - slack, whole_lo[axis])), cell.lo[axis]);
    box.hi[axis] = std::min(round_up(std::min(hi + slack, whole_hi[axis])), cell.hi[axis]);
    if (box.lo[axis] > box.hi[axis]) return std::nullopt;
  }
  return widen_flat(box);
}

}  // namespace sightline::accel

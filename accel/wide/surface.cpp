// Computes in columns of doubles, not fused; geometry::barycentric computes what doubles lose.
#include "accel/wide/surface.h"

#include <bit>
#include <cmath>

#include "accel/blocks/block.h"
#include "accel/geometry/intersect.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/wide/surface.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/wide/vectors-inl.h"

#ifndef SIGHTLINE_WIDE_HIT_TRIANGLES
#define SIGHTLINE_WIDE_HIT_TRIANGLES
namespace sightline::accel::wide {

/// The corners of the triangles that were hit.
struct HitTriangles {
  std::array<Column<double>, 3> a, b, c;
};

}  // namespace sightline::accel::wide
#endif

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

HWY_INLINE Vectors times(const Vectors& a, const Doubles& s) {
  return {a[0] * s, a[1] * s, a[2] * s};
}

HWY_INLINE void store_floats(const Doubles& x, Column<float>& out) {
  to_floats(x).store(out.data());
}

/// Clamps numbers to [0, 1], without negative zero.
HWY_INLINE Doubles clamped(const Doubles& x) {
  return min(max(x, Doubles::set(0)), Doubles::set(1)) + Doubles::set(0);
}

/// Sets weights; returns the lanes that need more than doubles.
HWY_INLINE std::uint32_t set_weights(const Rays& rays, const BestHits& hits,
                                     const HitTriangles& triangles, Surfaces& out) {
  const Vectors o = load(rays.origin), d = load(rays.direction);
  const Doubles t = Doubles::load(hits.t.data()) / Doubles::load(rays.unit.data());
  const Vectors p = times(d, t);
  const Vectors pa = minus(minus(load(triangles.a), o), p),
                pb = minus(minus(load(triangles.b), o), p),
                pc = minus(minus(load(triangles.c), o), p);
  const Doubles wa = dot(d, cross(pb, pc)), wb = dot(d, cross(pc, pa)), wc = dot(d, cross(pa, pb));
  const Doubles sum = wa + wb + wc;
  const Doubles size = max(max(max_norm(pa), max_norm(pb)), max_norm(pc));
  const Doubles u = clamped(wb / sum), v = clamped(wc / sum);
  const std::uint32_t beyond = u + v > Doubles::set(1);
  const Doubles share = u / (u + v);
  store_floats(Doubles::pick(beyond, share, u), out.u);
  store_floats(Doubles::pick(beyond, Doubles::set(1) - share, v), out.v);
  return abs(sum) <= Doubles::set(geometry::kEdgeOn) * size * size;
}

HWY_INLINE void set_normals(const HitTriangles& triangles, const Matrix& m, Surfaces& out) {
  const Vectors a = load(triangles.a);
  const Vectors n = cross(minus(load(triangles.b), a), minus(load(triangles.c), a));
  const auto set = [&](std::size_t i) { return Doubles::set(m[i]); };
  const auto transposed = [&](std::size_t column) {
    return set(column) * n[0] + set(4 + column) * n[1] + set(8 + column) * n[2];
  };
  const Vectors normal{transposed(0), transposed(1), transposed(2)};
  const Doubles squared = dot(normal, normal);
  const Doubles length = Doubles::each([&](std::size_t i) { return hn::Sqrt(squared.v[i]); });
  const Doubles per = Doubles::set(1) / length;
  for (std::size_t axis = 0; axis < 3; ++axis) store_floats(normal[axis] * per, out.normal[axis]);
  out.no_normal = ~((length > Doubles::set(0)) &
                    (length < Doubles::set(std::numeric_limits<double>::infinity())));
}

std::uint32_t set_surfaces(const Rays& rays, const BestHits& hits, const HitTriangles& triangles,
                           const Matrix& matrix, Surfaces& out) {
  set_normals(triangles, matrix, out);
  return set_weights(rays, hits, triangles, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::wide {

HWY_EXPORT(set_surfaces);

namespace {

void read_corners(const BestHits& hits, std::size_t from, std::size_t to, HitTriangles& out) {
  const blocks::Block block(hits.block[from]);
  const std::size_t triangle = hits.triangle[from];
  const geometry::Vec3f& center = hits.center[from];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float* column = block.x + axis * block.vertices;
    const auto corner = [&](std::size_t k) {
      return static_cast<double>(column[block.corner(k)[triangle]]) +
             static_cast<double>(center[axis]);
    };
    out.a[axis][to] = corner(0);
    out.b[axis][to] = corner(1);
    out.c[axis][to] = corner(2);
  }
}

geometry::Vec3f vertex(const std::array<Column<double>, 3>& columns, std::size_t lane) {
  return {static_cast<float>(columns[0][lane]), static_cast<float>(columns[1][lane]),
          static_cast<float>(columns[2][lane])};
}

}  // namespace

void find_surfaces(const GivenRays& given, const BestHits& hits, const Matrix& matrix,
                   std::uint32_t lanes, Surfaces& out) {
  Rays rays;
  transform(given, matrix, lanes, rays);
  HitTriangles triangles;
  const auto first = static_cast<std::size_t>(std::countr_zero(lanes));
  for (std::size_t lane = 0; lane < kLanes; ++lane)
    read_corners(hits, (lanes >> lane & 1) != 0 ? lane : first, lane, triangles);
  std::uint32_t lost =
      lanes & HWY_DYNAMIC_DISPATCH(set_surfaces)(rays, hits, triangles, matrix, out);
  for (; lost != 0; lost &= lost - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(lost));
    const geometry::LocalRay ray{
        {rays.origin[0][lane], rays.origin[1][lane], rays.origin[2][lane]},
        {rays.direction[0][lane], rays.direction[1][lane], rays.direction[2][lane]},
        rays.unit[lane]};
    const geometry::Barycentric weights =
        geometry::barycentric(ray, hits.t[lane] / rays.unit[lane], vertex(triangles.a, lane),
                              vertex(triangles.b, lane), vertex(triangles.c, lane));
    out.u[lane] = static_cast<float>(weights.u);
    out.v[lane] = static_cast<float>(weights.v);
  }
}

}  // namespace sightline::accel::wide
#endif  // HWY_ONCE

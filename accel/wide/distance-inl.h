// How far sixteen triangles are from a point, in floats with bounds of their errors.
// docs/distance_rule.md has the proof.
#if defined(SIGHTLINE_WIDE_DISTANCE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_WIDE_DISTANCE_INL
#undef SIGHTLINE_WIDE_DISTANCE_INL
#else
#define SIGHTLINE_WIDE_DISTANCE_INL
#endif

#include <cstdint>

#include "accel/wide/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

using Floats = Lanes<float, 16>;

/// A vector of each triangle.
struct Vectors16 {
  Floats x, y, z;

  friend HWY_INLINE Vectors16 operator-(const Vectors16& a, const Vectors16& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend HWY_INLINE Vectors16 operator*(const Vectors16& a, const Floats& s) {
    return {a.x * s, a.y * s, a.z * s};
  }
};

HWY_INLINE Floats dot(const Vectors16& a, const Vectors16& b) {
  return mul_add(a.x, b.x, mul_add(a.y, b.y, a.z * b.z));
}
HWY_INLINE Vectors16 cross(const Vectors16& a, const Vectors16& b) {
  return {mul_sub(a.y, b.z, a.z * b.y), mul_sub(a.z, b.x, a.x * b.z), mul_sub(a.x, b.y, a.y * b.x)};
}
HWY_INLINE Floats root(const Floats& x) {
  return Floats::each([&](std::size_t i) { return hn::Sqrt(x.v[i]); });
}
/// At least the length, and at most sqrt(3) times it.
HWY_INLINE Floats length_bound(const Vectors16& a) { return abs(a.x) + abs(a.y) + abs(a.z); }

/// The squared distance from the origin to a segment from `from` along `edge`, whose squared length
/// is `length`.
HWY_INLINE Floats squared_to_segment(const Vectors16& from, const Vectors16& edge,
                                     const Floats& length) {
  const Floats share =
      min(max(neg(dot(from, edge)) / max(length, Floats::set(0x1p-120f)), Floats::set(0)),
          Floats::set(1));
  const Vectors16 nearest{mul_add(share, edge.x, from.x), mul_add(share, edge.y, from.y),
                          mul_add(share, edge.z, from.z)};
  return dot(nearest, nearest);
}

/// Corners relative to the point, and edges as the differences of the vertices: where the point is
/// far away, they are much more exact than differences of corners. All are below 1.
struct Triangles16 {
  Vectors16 a, b, c, ab, ac, bc;
};

struct Distances {
  Floats low, high;  ///< The distances are not below, and not above.
};

/// The point is off by at most `off`.
HWY_INLINE Distances distances(const Triangles16& t, const Floats& off) {
  const Floats zero = Floats::set(0), one = Floats::set(1);
  const Floats ab = dot(t.ab, t.ab), ac = dot(t.ac, t.ac), bc = dot(t.bc, t.bc);
  const Floats to_edges =
      root(min(squared_to_segment(t.a, t.ab, ab),
               min(squared_to_segment(t.a, t.ac, ac), squared_to_segment(t.b, t.bc, bc))));
  const Vectors16 normal = cross(t.ab, t.ac);
  const Floats squared_edge = max(ab, max(ac, bc)), squared_normal = dot(normal, normal);
  const std::uint32_t has_normal = squared_normal > Floats::set(0x1p-100f);
  const Floats per_normal = one / root(Floats::pick(has_normal, squared_normal, one));
  const Floats to_plane = abs(dot(normal, t.a)) * per_normal;
  // Errors are shares of the distance to the farthest corner.
  const Floats size =
      max(length_bound(t.a), max(length_bound(t.b), length_bound(t.c))) + Floats::set(0x1p-60f);
  const Floats edge = max(length_bound(t.ab), max(length_bound(t.ac), length_bound(t.bc)));
  const Floats plane_error =
      mul_add(squared_edge * per_normal, Floats::set(0x1p-19f), Floats::set(0x1p-20f)) * size;
  // Whether the point is above the triangle.
  const Floats side_ab = dot(normal, cross(t.a, t.ab)), side_bc = dot(normal, cross(t.b, t.bc)),
               side_ca = neg(dot(normal, cross(t.c, t.ac)));
  const Floats least_side = min(side_ab, min(side_bc, side_ca));
  const Floats side_error =
      mul_add(squared_edge * edge * size, Floats::set(0x1p-19f), Floats::set(0x1p-100f));
  const std::uint32_t above = has_normal & (least_side > side_error);
  const std::uint32_t beside = has_normal & (least_side < neg(side_error));
  const Floats edge_error = size * Floats::set(0x1p-19f);
  const Floats beside_low = to_edges - edge_error;
  const Floats above_low =
      max(Floats::pick(has_normal, to_plane - plane_error, zero), beside_low - edge);
  const Floats low = Floats::pick(beside, beside_low, above_low);
  const Floats high = min(to_edges + edge_error,
                          Floats::pick(above, to_plane + plane_error, Floats::set(0x1p+30f)));
  return {low - off, high + off};
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#endif  // toggle

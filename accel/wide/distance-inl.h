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

/// Segments of triangles: `from` a corner along `edge`, whose squared length is `length`.
struct Segments {
  const Vectors16 &from, &edge;
  const Floats& length;
  Floats along;  ///< The product of the two.

  HWY_INLINE Segments(const Vectors16& a, const Vectors16& e, const Floats& squared_length)
      : from(a), edge(e), length(squared_length), along(dot(a, e)) {}

  /// The squared distance from the origin.
  HWY_INLINE Floats squared() const {
    const Floats share =
        min(max(neg(along) * reciprocal(max(length, Floats::set(0x1p-120f))), Floats::set(0)),
            Floats::set(1));
    const Vectors16 nearest{mul_add(share, edge.x, from.x), mul_add(share, edge.y, from.y),
                            mul_add(share, edge.z, from.z)};
    return dot(nearest, nearest);
  }
};

/// Corners relative to the point, and edges as the differences of the vertices: where the point is
/// far away, they are much more exact than differences of corners. All are below 1.
struct Triangles16 {
  Vectors16 a, b, ab, ac, bc;
};

struct Distances {
  Floats low, high;  ///< The distances are not below, and not above.
};

/// `size` is at least the distance of the farthest corner times the share by which the errors of
/// corners and edges may exceed those of differences. The point is off by at most `off`.
HWY_INLINE Distances distances(const Triangles16& t, const Floats& size, const Floats& share,
                               const Floats& off) {
  const Floats zero = Floats::set(0), one = Floats::set(1), tiny = Floats::set(0x1p-120f);
  const Floats ab = dot(t.ab, t.ab), ac = dot(t.ac, t.ac), bc = dot(t.bc, t.bc);
  const Segments on_ab(t.a, t.ab, ab), on_ac(t.a, t.ac, ac), on_bc(t.b, t.bc, bc);
  const Floats squared = min(on_ab.squared(), min(on_ac.squared(), on_bc.squared()));
  const Floats to_edges = squared * inverse_root(max(squared, tiny));
  const Vectors16 normal = cross(t.ab, t.ac);
  const Floats squared_edge = max(max(ab, tiny), max(ac, bc)), squared_normal = dot(normal, normal);
  const std::uint32_t has_normal = squared_normal > Floats::set(0x1p-100f);
  const Floats per_normal = inverse_root(Floats::pick(has_normal, squared_normal, one));
  const Floats to_plane = abs(dot(normal, t.a)) * per_normal;
  // Errors are shares of the distance to the farthest corner.
  const Floats edge = squared_edge * inverse_root(squared_edge) *
                      mul_add(share, Floats::set(0x1p-19f), Floats::set(1 + 0x1p-10f));
  const Floats plane_error =
      mul_add(squared_edge * per_normal, Floats::set(0x1p-19f), Floats::set(0x1p-20f)) * size;
  // Whether the point is above the triangle: the products of the normal and, for each edge, of a
  // corner and that edge. Their sum is the normal's square.
  const Floats between = dot(t.ab, t.ac);
  const Floats side_ab = mul_sub(on_ab.along, between, on_ac.along * ab),
               side_ca = mul_sub(on_ac.along, between, on_ab.along * ac),
               side_bc = squared_normal - side_ab - side_ca;
  const Floats least_side = min(side_ab, min(side_bc, side_ca));
  const Floats side_error =
      mul_add(squared_edge * edge * size, Floats::set(0x1p-17f), Floats::set(0x1p-100f));
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

// Bounds of the distance of the origin from a triangle, in the precision of its numbers.
//
// Any point x of the triangle bounds the distance from above by |x|. Any direction n bounds it from
// below by the least n . v / |n| of the three corners v: the triangle is on the far side of the
// plane across n through that corner. So a poor guess of the nearest point loosens the bounds and
// never breaks them. With unit roundoff u, and L at least as long as each corner: the computed
// x is within 7 u L of a point of the triangle, its length is off by 6 u L at most, and
// n . v / |n| by 10 u L, to first order. 32 u L bounds each of them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/support/quad.h"

namespace sightline::tests {

/// The unit roundoff, a square whose products do not underflow to anything that matters, and the
/// root, off by less than 4 units of rounding.
template <class T>
struct Precision;

/// For triangles whose farthest corner is between 2^-150 and 2^150 away.
template <>
struct Precision<double> {
  static constexpr double kUnit = 0x1p-53;
  static constexpr double kLeastSquare = 0x1p-700;
  static double root(double x) { return std::sqrt(x); }
};

/// For all doubles.
template <>
struct Precision<Quad> {
  static constexpr Quad kUnit = 0x1p-113;
  static constexpr Quad kLeastSquare = Quad{0x1p-1000} * Quad{0x1p-1000} * Quad{0x1p-1000} *
                                       Quad{0x1p-1000} * Quad{0x1p-1000} * Quad{0x1p-1000};
  static Quad root(Quad x) {
    if (x <= 0) return 0;
    Quad scale = 1;
    for (; x < Quad{0x1p-1000}; x *= Quad{0x1p+1000}) scale *= Quad{0x1p-500};
    for (; x > Quad{0x1p+1000}; x *= Quad{0x1p-1000}) scale *= Quad{0x1p+500};
    Quad y = std::sqrt(static_cast<double>(x));
    for (int step = 0; step < 2; ++step) y = (y + x / y) / 2;  // Doubles the number of right bits
    return y * scale;
  }
};

/// A point of the triangle, and a direction that is expected to show that no point is nearer.
template <class T>
struct NearGuess {
  accel::geometry::Vec3<T> point, direction;
  T square{};  // |point|^2
};

template <class T>
NearGuess<T> guess_on_segment(const accel::geometry::Vec3<T>& a,
                              const accel::geometry::Vec3<T>& b) {
  const accel::geometry::Vec3<T> edge = b - a;
  const T whole = dot(edge, edge), along = -dot(a, edge);
  if (!(along > 0)) return {a, a, dot(a, a)};
  if (!(along < whole)) return {b, b, dot(b, b)};
  const accel::geometry::Vec3<T> point = a + edge * (along / whole);
  // Perpendicular to the edge relative to |point|, not only relative to |a|.
  const accel::geometry::Vec3<T> direction = point - edge * (dot(point, edge) / whole);
  return {point, direction, dot(point, point)};
}

/// The foot on the plane where it is inside, as weights of the corners; else an infinite square.
template <class T>
NearGuess<T> guess_inside(const std::array<accel::geometry::Vec3<T>, 3>& v,
                          const accel::geometry::Vec3<T>& normal) {
  constexpr T kLeast = Precision<T>::kLeastSquare;
  const T wa = dot(normal, cross(v[1], v[2])), wb = dot(normal, cross(v[2], v[0])),
          wc = dot(normal, cross(v[0], v[1])), sum = wa + wb + wc;
  if (!(wa >= 0 && wb >= 0 && wc >= 0 && sum > kLeast)) return {{}, {}, HUGE_VAL};
  const accel::geometry::Vec3<T> point = (v[0] * wa + v[1] * wb + v[2] * wc) * (1 / sum);
  return {point, normal, dot(point, point)};
}

/// The least n . v / |n|; zero for a direction that is too short.
template <class T>
T least_along(const std::array<accel::geometry::Vec3<T>, 3>& v, const accel::geometry::Vec3<T>& n) {
  const T square = dot(n, n);
  if (!(square > Precision<T>::kLeastSquare)) return 0;
  const T least = std::min(std::min(dot(n, v[0]), dot(n, v[1])), dot(n, v[2]));
  return least / Precision<T>::root(square);
}

template <class T>
struct DistanceBounds {
  T lower{}, upper{};
};

/// The corners are seen from the point. `slack` is at least 32 units of rounding times the farthest
/// of them, plus what each of them may be off.
template <class T>
DistanceBounds<T> distance_bounds(const std::array<accel::geometry::Vec3<T>, 3>& v, T slack) {
  NearGuess<T> best = guess_on_segment(v[0], v[1]);
  for (const NearGuess<T>& other : {guess_on_segment(v[1], v[2]), guess_on_segment(v[2], v[0])}) {
    if (other.square < best.square) best = other;
  }
  accel::geometry::Vec3<T> normal = cross(v[1] - v[0], v[2] - v[0]);
  const NearGuess<T> inside = guess_inside(v, normal);
  if (inside.square < best.square) best = inside;
  if (dot(normal, v[0]) < 0) normal = normal * T{-1};
  const T along = std::max(least_along(v, normal), least_along(v, best.direction));
  return {along - slack, Precision<T>::root(best.square) + slack};
}

}  // namespace sightline::tests

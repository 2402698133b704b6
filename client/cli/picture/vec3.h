// Three doubles, as far as a camera needs them.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace sightline::client::cli::picture {

using Vec3 = std::array<double, 3>;

inline Vec3 add(const Vec3& a, const Vec3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vec3 sub(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vec3 scale(const Vec3& a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
inline double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double length(const Vec3& a) { return std::sqrt(dot(a, a)); }
inline Vec3 unit(const Vec3& a) { return scale(a, 1 / length(a)); }
/// a at s = 0, b at s = 1.
inline Vec3 mix(const Vec3& a, const Vec3& b, double s) {
  return add(scale(a, 1 - s), scale(b, s));
}

}  // namespace sightline::client::cli::picture

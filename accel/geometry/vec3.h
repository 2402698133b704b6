// Vectors of three numbers. Vertices and cells are float, rays are double.
#pragma once

#include <cmath>
#include <cstddef>

namespace sightline::accel::geometry {

template <class T>
struct Vec3 {
  T x{}, y{}, z{};

  // This is one indexed load. Choosing between three members would cost two conditional moves in
  // every inner loop.
  T& operator[](std::size_t axis) { return reinterpret_cast<T*>(this)[axis]; }
  const T& operator[](std::size_t axis) const { return reinterpret_cast<const T*>(this)[axis]; }
  constexpr bool operator==(const Vec3&) const = default;

  template <class U>
  explicit constexpr operator Vec3<U>() const {
    return {static_cast<U>(x), static_cast<U>(y), static_cast<U>(z)};
  }
};

static_assert(sizeof(Vec3<float>) == 3 * sizeof(float) &&
              sizeof(Vec3<double>) == 3 * sizeof(double));

using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;

template <class T>
constexpr Vec3<T> operator+(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
constexpr Vec3<T> operator-(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
constexpr Vec3<T> operator*(const Vec3<T>& a, T s) {
  return {a.x * s, a.y * s, a.z * s};
}
template <class T>
constexpr T dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
constexpr Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
T length(const Vec3<T>& a) {
  return std::sqrt(dot(a, a));
}
template <class T>
bool is_finite(const Vec3<T>& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

}  // namespace sightline::accel::geometry

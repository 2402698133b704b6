// Rays in columns: views of numbers as a message or an array of structs holds them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "accel/geometry/ray.h"

namespace sightline::accel::geometry {

/// A number of each ray, in memory that the column does not own. Any alignment.
struct RealColumn {
  const void* data = nullptr;  ///< The number of the first ray.
  std::size_t stride = 0;      ///< Elements from ray to ray; 0: one number for all rays.
  bool float64 = true;         ///< Whether the elements are doubles, else floats.

  std::size_t element() const { return float64 ? sizeof(double) : sizeof(float); }
  const std::byte* at(std::size_t ray) const {
    return static_cast<const std::byte*>(data) + ray * stride * element();
  }
  double operator[](std::size_t ray) const {
    double number;
    float narrow;
    if (float64) {
      std::memcpy(&number, at(ray), sizeof(number));
      return number;
    }
    std::memcpy(&narrow, at(ray), sizeof(narrow));
    return static_cast<double>(narrow);
  }
};

/// A mask of each ray, in memory that the column does not own. Any alignment.
struct MaskColumn {
  const void* data = &kAllMasks;
  std::size_t stride = 0;  ///< Masks from ray to ray; 0: one mask for all rays.

  std::uint32_t operator[](std::size_t ray) const {
    std::uint32_t mask;
    std::memcpy(&mask, static_cast<const std::byte*>(data) + ray * stride * sizeof(mask),
                sizeof(mask));
    return mask;
  }
};

/// A column with one number for all rays. The number must outlive it.
inline RealColumn for_all(const double& number) { return {&number, 0, true}; }

/// Columns x, y, z of rows of three elements.
inline std::array<RealColumn, 3> columns_of_rows(const void* rows, bool float64) {
  std::array<RealColumn, 3> columns;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t offset = axis * (float64 ? sizeof(double) : sizeof(float));
    columns[axis] = {static_cast<const std::byte*>(rows) + offset, 3, float64};
  }
  return columns;
}

inline constexpr double kFromOrigin = 0;  ///< The default tmin.

/// A view of rays. Copies are cheap; the numbers must outlive them.
struct RayColumns {
  std::size_t size = 0;  ///< The number of rays.
  std::array<RealColumn, 3> origin, direction;
  RealColumn tmin = for_all(kFromOrigin), tmax = for_all(kInfinity);
  MaskColumn mask;

  Ray operator[](std::size_t i) const {
    return {.origin = {origin[0][i], origin[1][i], origin[2][i]},
            .direction = {direction[0][i], direction[1][i], direction[2][i]},
            .tmin = tmin[i],
            .tmax = tmax[i],
            .mask = mask[i]};
  }
};

/// The columns of an array of structs.
inline RayColumns columns_of(std::span<const Ray> rays) {
  static_assert(sizeof(Ray) % sizeof(double) == 0);
  constexpr std::size_t kStride = sizeof(Ray) / sizeof(double);
  if (rays.empty()) return {};
  const Ray& ray = rays.front();
  const auto column = [](const double& number) { return RealColumn{&number, kStride, true}; };
  return {.size = rays.size(),
          .origin = {column(ray.origin.x), column(ray.origin.y), column(ray.origin.z)},
          .direction = {column(ray.direction.x), column(ray.direction.y), column(ray.direction.z)},
          .tmin = column(ray.tmin),
          .tmax = column(ray.tmax),
          .mask = {&ray.mask, sizeof(Ray) / sizeof(ray.mask)}};
}

}  // namespace sightline::accel::geometry

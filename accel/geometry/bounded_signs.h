// Signs of a face as seen from a point, with bounds of their errors. docs/distance_rule.md proves
// them.
#pragma once

#include <array>
#include <cmath>

#include "accel/geometry/closest_feature.h"
#include "accel/geometry/seen_face.h"

namespace sightline::accel::geometry {

/// A computed sign is certain beyond this share of the sum of its terms' sizes: 11 roundings of
/// 2^-53, and 52 of 2^-106.
inline constexpr double kSignShare = 0x1p-49;
inline constexpr double kFineSignShare = 0x1p-100;

inline Vec3d sizes(const Vec3d& v, double more) {
  return {std::fabs(v.x) + more, std::fabs(v.y) + more, std::fabs(v.z) + more};
}

/// The cross product with all signs positive: the sizes of its terms.
inline Vec3d cross_sizes(const Vec3d& a, const Vec3d& b) {
  return {a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x};
}

/// Signs for nearest_feature() in numbers T, which are doubles or double-doubles.
template <class T>
class BoundedSigns {
 public:
  /// `share` of the sizes of terms is the error. A corner's coordinates are off by 2^-53 `more`
  /// beside their own rounding.
  BoundedSigns(const SeenFace& face, double share, double more) : share_(share) {
    for (std::size_t i = 0; i < 3; ++i) {
      assign(face.corner[i], corner_[i]);
      assign(face.edge[i], edge_[i]);
      corner_size_[i] = sizes(high(face.corner[i]), more);
      edge_size_[i] = sizes(high(face.edge[i]), 2 * more);
    }
  }

  Sign along(std::size_t corner, std::size_t edge) const {
    return sign(dot(corner_[corner], edge_[edge]), dot(corner_size_[corner], edge_size_[edge]));
  }
  Sign side(std::size_t i) const {
    // With an edge of length 0 the normal would be 0 by cancellation, which is not certain.
    if (!has_length(0) || !has_length(1) || !has_length(2)) return {};
    return sign(dot(cross(edge_[i], corner_[i]), cross(edge_[2], edge_[0])),
                dot(cross_sizes(edge_size_[i], corner_size_[i]),
                    cross_sizes(edge_size_[2], edge_size_[0])));
  }
  bool has_length(std::size_t i) const { return edge_size_[i] != Vec3d{}; }

 private:
  static void assign(const Vec3dd& from, Vec3d& to) { to = high(from); }
  static void assign(const Vec3dd& from, Vec3dd& to) { to = from; }

  Sign sign(const T& value, double size) const {
    const double bound = share_ * size;
    if (high(value) > bound) return {1, true};
    if (high(value) < -bound) return {-1, true};
    return {0, size == 0};  // All terms are 0
  }

  double share_;
  std::array<Vec3<T>, 3> corner_, edge_;
  std::array<Vec3d, 3> corner_size_, edge_size_;
};

}  // namespace sightline::accel::geometry

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
  BoundedSigns(const SeenFace& face, double share, double more)
      : is_off_(more > 0), share_(is_off_ ? share + kShareOfDifference : share) {
    for (std::size_t i = 0; i < 3; ++i) {
      assign(face.corner[i], corner_[i]);
      assign(face.edge[i], edge_[i]);
      sizes_.corner[i] = sizes(high(face.corner[i]), 0);
      sizes_.edge[i] = sizes(high(face.edge[i]), 0);
      if (!is_off_) continue;
      largest_.corner[i] = sizes(high(face.corner[i]), 0x1p-53 * more);
      largest_.edge[i] = sizes(high(face.edge[i]), 0x1p-52 * more);
    }
  }

  Sign along(std::size_t corner, std::size_t edge) const {
    return sign(dot(corner_[corner], edge_[edge]),
                [=](const Sizes& s) { return dot(s.corner[corner], s.edge[edge]); });
  }
  Sign side(std::size_t i) const {
    // With an edge of length 0 the normal would be 0 by cancellation, which is not certain.
    if (!has_length(0) || !has_length(1) || !has_length(2)) return {};
    return sign(dot(cross(edge_[i], corner_[i]), cross(edge_[2], edge_[0])), [=](const Sizes& s) {
      return dot(cross_sizes(s.edge[i], s.corner[i]), cross_sizes(s.edge[2], s.edge[0]));
    });
  }
  bool has_length(std::size_t i) const { return is_off_ || sizes_.edge[i] != Vec3d{}; }

 private:
  struct Sizes {
    std::array<Vec3d, 3> corner, edge;
  };

  static void assign(const Vec3dd& from, Vec3d& to) { to = high(from); }
  static void assign(const Vec3dd& from, Vec3dd& to) { to = from; }

  /// `size_of` is the expression with all signs positive. Numbers that are off by so much change it
  /// by no more than its value grows if all sizes grow by that.
  template <class SizeOf>
  Sign sign(const T& value, const SizeOf& size_of) const {
    const double size = size_of(sizes_);
    double bound = share_ * size;
    if (is_off_) {
      const double largest = size_of(largest_);
      bound = (largest - size) + share_ * largest;
    }
    if (high(value) > bound) return {1, true};
    if (high(value) < -bound) return {-1, true};
    return {0, bound == 0};  // All terms are 0
  }

  /// The roundings of the difference of two sizes: each is off by 14 of 2^-53.
  static constexpr double kShareOfDifference = 0x1p-48;

  bool is_off_;
  double share_;
  std::array<Vec3<T>, 3> corner_, edge_;
  Sizes sizes_;
  Sizes largest_;  // if numbers are off
};

}  // namespace sightline::accel::geometry

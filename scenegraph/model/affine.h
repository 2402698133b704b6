// Double-precision affine transforms: 3x4, row-major, parent from local.
#pragma once

#include <array>
#include <optional>

#include "accel/geometry/vec3.h"

namespace sightline::scenegraph::model {

using accel::geometry::Vec3d;

struct Affine {
  /// Rows of [linear | translation].
  std::array<double, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

  constexpr bool operator==(const Affine&) const = default;

  Vec3d point(const Vec3d& p) const {
    return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
            m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
            m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
  }
  Vec3d direction(const Vec3d& d) const {
    return {m[0] * d.x + m[1] * d.y + m[2] * d.z, m[4] * d.x + m[5] * d.y + m[6] * d.z,
            m[8] * d.x + m[9] * d.y + m[10] * d.z};
  }
  /// The transposed linear part times n. The inverse transform's maps normals.
  Vec3d transposed(const Vec3d& n) const {
    return {m[0] * n.x + m[4] * n.y + m[8] * n.z, m[1] * n.x + m[5] * n.y + m[9] * n.z,
            m[2] * n.x + m[6] * n.y + m[10] * n.z};
  }
};

/// The transform that applies `inner`, then `outer`.
Affine compose(const Affine& outer, const Affine& inner);

bool is_finite(const Affine& a);

/// The inverse; nothing where the linear part is singular, not finite, or so nearly singular
/// (condition above kMaxCondition, or numbers beyond the range of doubles) that no ray could be
/// transformed by it. Its linear part is off by at most 2^-48 of its norm, times the condition.
std::optional<Affine> inverse(const Affine& a);

inline constexpr double kMaxCondition = 1e12;

/// |A| |A^-1| in the Frobenius norm of the linear parts.
double condition(const Affine& a, const Affine& inverse_of_a);

}  // namespace sightline::scenegraph::model

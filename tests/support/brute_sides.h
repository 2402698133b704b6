// Sides of points by the definition of the rule of normals: every face of the answering node, in
// 113 bits. Shares no code with the product.
#pragma once

#include <optional>

#include "tests/support/brute_force.h"

namespace sightline::tests {

/// Whether `p` is behind the face `primitive` of the node, which is its nearest, and the other
/// faces of the node that contain the nearest point; nothing where rounding could change it, as for
/// points on a face. All faces must be finite.
std::optional<bool> is_behind(const PlacedMesh& node, std::uint32_t primitive,
                              const accel::geometry::Vec3d& p);

}  // namespace sightline::tests

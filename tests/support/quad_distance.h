// The distance of a point from a face in 113 bits, where they decide how it is rounded.
#pragma once

#include <optional>

#include "scenegraph/model/affine.h"

namespace sightline::tests {

/// rational_distance(p, world_from_local.m, a, b, c), or nothing where the bounds of 113 bits do
/// not round to one double.
std::optional<double> quad_distance(const accel::geometry::Vec3d& p,
                                    const scenegraph::model::Affine& world_from_local,
                                    const accel::geometry::Vec3f& a,
                                    const accel::geometry::Vec3f& b,
                                    const accel::geometry::Vec3f& c);

}  // namespace sightline::tests

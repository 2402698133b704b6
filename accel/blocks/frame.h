// The frame of the vertices in leaf blocks: mesh coordinates minus a center.
#pragma once

#include "accel/geometry/aabb.h"

namespace sightline::accel::blocks {

/// A center for which v - center is exact in float, for every float v inside the bounds.
///
/// On each axis it is the bound s of smaller magnitude if both bounds have the same sign, the
/// larger magnitude is at most 2 |s|, and a unit in the last place of s is a normal float. Then |s|
/// <= |v|
/// <= 2 |s| and the signs are equal, so v - s is a float by Sterbenz' lemma. It is a multiple of a
/// unit in the last place of s, as v is, so it is zero or normal and survives threads that flush
/// denormals. Otherwise the center is 0, and v stays as it is. Empty bounds: the origin.
geometry::Vec3f frame_center(const geometry::Aabb& bounds);

/// Returns v - center on one axis. Where the center is 0 it returns v as it is, which keeps
/// denormals.
inline float relative(float v, float center) { return center == 0 ? v : v - center; }

}  // namespace sightline::accel::blocks

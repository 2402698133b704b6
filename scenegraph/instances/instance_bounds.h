// The boxes of instances and groups in the scene's tree.
//
// Why a group's box holds those of all instances below it, bit for bit: in exact arithmetic its
// box in its own frame holds them (Subtree::box). An instance's box is off that by the rounding of
// its world transform, at most 65 products of four terms each within reach, and by its own pad,
// which goes with the condition of its transform; a group's box is padded by more than both. What
// follows (taking off the center, the narrowing to float) is monotonic but for widen_flat, whose
// two floats a group gets beforehand.
#pragma once

#include "accel/geometry/aabb.h"
#include "scenegraph/hierarchy/node_summary.h"

namespace sightline::scenegraph::instances {

/// Of a mesh's box, padded for the rounding of the transform and of its inverse. Relative to the
/// center, rounded outward.
accel::geometry::Aabb instance_box(const model::Affine& world_from_local,
                                   const model::Affine& local_from_world,
                                   const accel::geometry::Aabb& mesh,
                                   const accel::geometry::Vec3d& center);

/// Of a subtree with instances: holds the box of each.
accel::geometry::Aabb group_box(const model::Affine& world_from_local,
                                const hierarchy::Subtree& subtree,
                                const accel::geometry::Vec3d& center);

/// The part of `box` that lies in `outer`: all of it, unless rounding went beyond what was
/// foreseen. Never empty, never beyond `outer`.
accel::geometry::Aabb confined(const accel::geometry::Aabb& box,
                               const accel::geometry::Aabb& outer);

}  // namespace sightline::scenegraph::instances

// The boxes of instances and groups in the scene's tree.
//
// A group's box holds the boxes of all instances below it, bit for bit. Why: in exact arithmetic
// the box in the group's own frame holds them (NodeSummary::box). An instance's box differs from
// that by the rounding of its world transform (a product of four terms, each up to the magnitude,
// for each level below the group) and by its own padding, which grows with the condition of its
// transform. A group's box is padded by more than both. The later steps (subtraction of the center,
// narrowing to float) are monotonic except for widen_flat, so a group's box gets its two floats
// beforehand.
#pragma once

#include "accel/geometry/aabb.h"
#include "scenegraph/hierarchy/node_summary.h"

namespace sightline::scenegraph::instances {

/// The box of a mesh's box in the world, padded for the rounding of the transform and of its
/// inverse; relative to the center, rounded outward.
accel::geometry::Aabb instance_box(const model::Affine& world_from_local,
                                   const model::Affine& local_from_world,
                                   const accel::geometry::Aabb& mesh,
                                   const accel::geometry::Vec3d& center);

/// The box of a group with instances, which holds the box of each.
accel::geometry::Aabb group_box(const model::Affine& world_from_local,
                                const hierarchy::NodeSummary& summary,
                                const accel::geometry::Vec3d& center);

/// The part of `box` that lies in `outer`: all of it, unless rounding exceeded the padding. Never
/// empty, never beyond `outer`.
accel::geometry::Aabb confined(const accel::geometry::Aabb& box,
                               const accel::geometry::Aabb& outer);

}  // namespace sightline::scenegraph::instances

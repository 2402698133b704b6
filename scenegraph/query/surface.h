// The weights and the normal of a hit.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/geometry/ray.h"
#include "accel/wide/unique_hits.h"
#include "scenegraph/instances/instance_group.h"
#include "scenegraph/instances/scene_trees.h"
#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph::query {

/// Sets u, v and the normal: a pure function of the ray, the triangle, t and the instance.
void set_surface(const instances::Instance& instance, const accel::geometry::Ray& ray,
                 accel::geometry::Hit& hit);

/// As set_surface(), for the point at the ray's origin: the weights are those of the nearest point.
void set_surface_of_point(const instances::Instance& instance,
                          const model::Affine& world_from_local, const accel::geometry::Ray& ray,
                          accel::geometry::Hit& hit);

/// Sets the surface of a hit of a ray or, if it is one of `points`, of a point, in an instance of
/// the trees.
void set_surface(const instances::OpenTrees& trees, std::size_t instance, bool points,
                 const accel::geometry::Ray& ray, accel::geometry::Hit& hit);

/// The point of a face that is nearest to a point, all in the scene. The revision has the face.
accel::geometry::Vec3d nearest_point(const revision::Snapshot& snapshot, model::NodeId node,
                                     std::uint32_t primitive, const accel::geometry::Vec3d& point);

/// A listed hit, without its surface.
accel::geometry::Hit hit_of(const accel::wide::ListedHit& listed);

}  // namespace sightline::scenegraph::query

// The weights and the normal of a hit.
#pragma once

#include "accel/geometry/ray.h"
#include "accel/wide/unique_hits.h"
#include "scenegraph/instances/instance_group.h"
#include "scenegraph/instances/scene_trees.h"

namespace sightline::scenegraph::query {

/// Sets u, v and the normal: a pure function of the ray, the triangle, t and the instance.
void set_surface(const instances::Instance& instance, const accel::geometry::Ray& ray,
                 accel::geometry::Hit& hit);

/// A listed hit of the ray, with its surface if that is asked for.
accel::geometry::Hit hit_of(const accel::wide::ListedHit& listed, const instances::OpenTrees& trees,
                            const accel::geometry::Ray& ray, bool surface);

}  // namespace sightline::scenegraph::query

// The weights and the normal of a hit.
#pragma once

#include "accel/geometry/ray.h"
#include "scenegraph/instances/instance_group.h"

namespace sightline::scenegraph::query {

/// Sets u, v and the normal: a pure function of the ray, the triangle, t and the instance.
void set_surface(const instances::Instance& instance, const accel::geometry::Ray& ray,
                 accel::geometry::Hit& hit);

}  // namespace sightline::scenegraph::query

// What a hit says of the surface that it lies on.
#pragma once

#include "accel/geometry/ray.h"
#include "scenegraph/instances/instance_list.h"

namespace sightline::scenegraph::query {

/// Fills in the hit, a fresh one, of this ray at t on a triangle of the instance: a pure function
/// of these. Barycentrics and the normal are left out unless `surface`.
void set_hit(const instances::Instance& instance, const accel::geometry::Ray& ray, double t,
             std::uint32_t primitive, bool surface, accel::geometry::Hit& hit);

}  // namespace sightline::scenegraph::query

// The surface data of a hit.
#pragma once

#include "accel/geometry/ray.h"
#include "scenegraph/instances/instance_list.h"

namespace sightline::scenegraph::query {

/// Fills in a fresh hit of this ray at t on a triangle of the instance. A pure function of its
/// arguments. Barycentrics and the normal are computed only if `surface`.
void set_hit(const instances::Instance& instance, const accel::geometry::Ray& ray, double t,
             std::uint32_t primitive, bool surface, accel::geometry::Hit& hit);

}  // namespace sightline::scenegraph::query

// The face nearest to a point, by Embree's point queries.
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <span>
#include <vector>

#include "accel/geometry/ray.h"
#include "scenegraph/model/affine.h"
#include "tests/bench/embree/layout.h"

namespace sightline::bench {

/// Sets the node, primitive and distance (t) of the nearest face of each point, as a callback in
/// floats finds it, and returns the seconds inside Embree. The scene has the uses of the `meshes`
/// that have faces, in this order: geometries, or instances of a mesh with several. Points are
/// transformed by `frame` in double and then rounded to float. Parallel.
double find_nearest_by_embree(RTCScene scene, const std::vector<EmbreeMesh>& meshes,
                              const scenegraph::model::Affine& frame,
                              std::span<const accel::geometry::Vec3d> points,
                              std::span<accel::geometry::Hit> hits);

}  // namespace sightline::bench

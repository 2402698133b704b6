// A metric of hierarchies that surface area does not cover: the cost of the points where rays end.
#pragma once

#include "accel/geometry/triangle_mesh.h"
#include "accel/published/bvh/bvh.h"

namespace sightline::bench {

/// The end-point overlap (Aila, Karras, Laine 2013, "On Quality Metrics of Bounding Volume
/// Hierarchies", section 4): over all nodes, the area of triangles in the node's box that none of
/// the leaves below it references, divided by the total area, times the cost of a visit
/// (kMeasuredTraverse, or kMeasuredIntersect for each reference). Rays that end on such a triangle
/// visit the node in vain. Parallel in the caller's arena; sums in a fixed order.
double end_point_overlap(const accel::published::bvh::Bvh& bvh,
                         const accel::geometry::MeshView& mesh);

}  // namespace sightline::bench

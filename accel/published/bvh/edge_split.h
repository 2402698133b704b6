// The Edge Volume Heuristic: triangles that are not axis-aligned are split before the hierarchy is
// built. Source: Dammertz, Keller 2008, "The Edge Volume Heuristic - Robust Triangle Subdivision
// for Improved BVH Performance".
#pragma once

#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/reference.h"
#include "accel/published/bvh/pre_split.h"

namespace sightline::accel::published::bvh {

/// Splits triangles at the middle of the edge whose bounds have the largest volume, while that is
/// above rule.threshold of the volume of the root. Triangles with axis-aligned edges stay whole.
///
/// In, out, touches: as split_early (early_split.h). A piece is the box around the corners of a
/// part of a triangle, computed in double and rounded outward.
std::vector<kdtree::Reference> split_edges(const geometry::MeshView& mesh,
                                           std::vector<kdtree::Reference> refs,
                                           const PreSplitRule& rule,
                                           kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh

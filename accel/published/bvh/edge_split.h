// The Edge Volume Heuristic: triangles that lie askew are split before the hierarchy is built.
// Source: Dammertz, Keller 2008, "The Edge Volume Heuristic - Robust Triangle Subdivision for
// Improved BVH Performance".
#pragma once

#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/reference.h"
#include "accel/published/bvh/pre_split.h"

namespace sightline::accel {

/// Splits triangles in the middle of the edge whose bounds have the largest volume, while that is
/// above rule.threshold of the volume around all. Triangles with axis-aligned edges stay whole.
///
/// In, out, touches: as split_early (early_split.h). Pieces are boxes around parts of triangles,
/// which are bounded by their corners, computed in double and rounded outward.
std::vector<BoxRef> split_edges(const MeshView& mesh, std::vector<BoxRef> refs,
                                const PreSplitRule& rule, BuildCounters& counters);

}  // namespace sightline::accel

// Early Split Clipping: large boxes are split before the hierarchy is built. Source: Ernst, Greiner
// 2007, "Early Split Clipping for Bounding Volume Hierarchies".
#pragma once

#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/reference.h"
#include "accel/published/bvh/pre_split.h"

namespace sightline::accel::published::bvh {

/// Splits boxes in the middle of their longest axis, and clips each half to its part of the
/// triangle, while their surface is above rule.threshold of the surface of the root.
///
/// In: one reference per face, bounds through widen_flat. Out: pieces in the order of their
/// references, so those of one face are together; the pieces of a face cover it. The builder counts
/// a face once per piece, as in the paper; BvhGrowth::leaf drops duplicates within a leaf.
///
/// Touches_prepare: one per box made. Deterministic. Throws std::bad_alloc.
std::vector<kdtree::Reference> split_early(const geometry::MeshView& mesh,
                                           std::vector<kdtree::Reference> refs,
                                           const PreSplitRule& rule,
                                           kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh

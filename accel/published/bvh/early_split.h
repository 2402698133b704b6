// Early Split Clipping: large boxes are split before the hierarchy is built. Source: Ernst, Greiner
// 2007, "Early Split Clipping for Bounding Volume Hierarchies".
#pragma once

#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/reference.h"
#include "accel/published/bvh/pre_split.h"

namespace sightline::accel::published::bvh {

/// Splits boxes in the middle of their longest axis, each half drawn tight around its part of the
/// triangle, while their surface is above rule.threshold of the surface around all.
///
/// In: one reference a face, bounds through widen_flat. Out: pieces in the order of what they come
/// from, those of one face together; all of a face lies in its pieces. A face counts several times
/// where a hierarchy is built over them, as in the paper; BvhGrowth::leaf names it once in a leaf.
///
/// Touches_prepare: a box made. Deterministic. Throws std::bad_alloc.
std::vector<kdtree::Reference> split_early(const geometry::MeshView& mesh,
                                           std::vector<kdtree::Reference> refs,
                                           const PreSplitRule& rule,
                                           kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh

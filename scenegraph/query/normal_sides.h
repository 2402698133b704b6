// On which side of a scene's surfaces points are, by the normals where they are nearest.
#pragma once

#include <span>

#include "accel/geometry/ray_columns.h"
#include "proto/result.h"
#include "scenegraph/revision/snapshot.h"
#include "scenegraph/sides.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph::query {

/// Whether points lie behind their nearest faces: SideRule::kNormal. Arguments and errors are those
/// of find_sides(); stats are the sum of its searches. A point on the surface, and one for which
/// there is no face, is outside. Memory: in proportion to the points and, for each thread, to the
/// faces that meet at one corner.
Result<TraceStats> sides_by_normal(const revision::Snapshot& snapshot,
                                   const accel::geometry::RayColumns& points, std::span<Side> sides,
                                   const TraceOptions& options);

}  // namespace sightline::scenegraph::query

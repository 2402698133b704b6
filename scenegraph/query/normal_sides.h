// Whether points lie behind their nearest faces.
#pragma once

#include <span>

#include "scenegraph/sides.h"

namespace sightline::scenegraph::query {

/// SideRule::kNormal. As find_sides().
Result<TraceStats> sides_by_normal(const revision::Snapshot& snapshot,
                                   const accel::geometry::RayColumns& points, std::span<Side> sides,
                                   const TraceOptions& options);

}  // namespace sightline::scenegraph::query

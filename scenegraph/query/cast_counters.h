// What the rays of a caster walked and built.
#pragma once

#include "accel/kdtree/reference.h"
#include "accel/kdtree/walk_counters.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph::query {

struct CastCounters {
  accel::kdtree::WalkCounters walked;
  /// What was built in the static tree, and in the meshes that rays entered through it.
  accel::kdtree::BuildCounters static_built;
  /// What was built in the dynamic trees, and in the meshes that rays entered through them.
  accel::kdtree::BuildCounters dynamic_built;

  void add_to(TraceStats& stats) const {
    stats.traversal_steps += walked.steps;
    stats.triangle_tests += walked.tests;
    stats.cells_expanded += static_built.cells_expanded + dynamic_built.cells_expanded;
    stats.trees_begun += static_built.trees_begun + dynamic_built.trees_begun;
    stats.touches += static_built.touches + dynamic_built.touches;
    stats.touches_prepare += static_built.touches_prepare + dynamic_built.touches_prepare;
    stats.dynamic_touches += dynamic_built.touches + dynamic_built.touches_prepare;
    stats.build_seconds += static_built.seconds + dynamic_built.seconds;
  }
};

}  // namespace sightline::scenegraph::query

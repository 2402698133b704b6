// What the rays of a caster walked and built.
#pragma once

#include "accel/kdtree/reference.h"
#include "accel/kdtree/walk_counters.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph::query {

inline void add(const accel::kdtree::BuildCounters& built, TraceStats& stats) {
  stats.cells_expanded += built.cells_expanded;
  stats.trees_begun += built.trees_begun;
  stats.touches += built.touches;
  stats.touches_prepare += built.touches_prepare;
  stats.build_seconds += built.seconds;
}

struct CastCounters {
  accel::kdtree::WalkCounters walked;
  /// What was built in the static tree, and in the meshes that rays entered through it.
  accel::kdtree::BuildCounters static_built;
  /// What was built in the dynamic trees, and in the meshes that rays entered through them.
  accel::kdtree::BuildCounters dynamic_built;

  void add_to(TraceStats& stats) const {
    stats.traversal_steps += walked.steps;
    stats.triangle_tests += walked.tests;
    add(static_built, stats);
    add(dynamic_built, stats);
    stats.dynamic_touches += dynamic_built.touches + dynamic_built.touches_prepare;
  }
};

}  // namespace sightline::scenegraph::query

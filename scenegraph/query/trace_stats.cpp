// Adds up the work of blocks.
#include "scenegraph/query/trace_stats.h"

namespace sightline::scenegraph::query {

TraceStats& TraceStats::operator+=(const TraceStats& o) {
  rays += o.rays;
  hits += o.hits;
  invalid += o.invalid;
  hits_found += o.hits_found;
  cut_off += o.cut_off;
  traversal_steps += o.traversal_steps;
  triangle_tests += o.triangle_tests;
  instances_entered += o.instances_entered;
  cells_expanded += o.cells_expanded;
  touches += o.touches;
  dynamic_touches += o.dynamic_touches;
  touches_prepare += o.touches_prepare;
  build_seconds += o.build_seconds;
  return *this;
}

}  // namespace sightline::scenegraph::query

#include "scenegraph/query/normal_sides.h"
namespace sightline::scenegraph::query {
Result<TraceStats> sides_by_normal(const revision::Snapshot&, const accel::geometry::RayColumns&,
                                   std::span<Side>, const TraceOptions&) {
  return Error{Code::kUnimplemented, "not yet", "NOT_YET"};
}
}  // namespace sightline::scenegraph::query

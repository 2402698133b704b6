// What rays do at cells that are not built.
#pragma once

#include "accel/lazy/walk_lazily.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph::query {

inline accel::lazy::OnDeferred on_deferred(Growth growth) {
  switch (growth) {
    case Growth::kDemand:
      return accel::lazy::OnDeferred::kDemand;
    case Growth::kNone:
      return accel::lazy::OnDeferred::kScan;
    case Growth::kBuiltOnly:
      return accel::lazy::OnDeferred::kSkip;
    case Growth::kFirstTouch:
    case Growth::kFull:
      break;
  }
  return accel::lazy::OnDeferred::kExpand;
}

}  // namespace sightline::scenegraph::query

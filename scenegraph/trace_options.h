// What a batch of rays asks for: the names that callers of trace.h use.
#pragma once

#include "scenegraph/query/trace_options.h"

namespace sightline::scenegraph {

using query::Growth;
using query::QueryKind;
using query::TraceOptions;

}  // namespace sightline::scenegraph

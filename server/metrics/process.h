// What the process uses, under the names that Prometheus' own libraries use.
#pragma once

#include "server/metrics/samples.h"

namespace sightline::server::metrics {

/// Adds the processor time, the memory, the open files and their limit, and the time of the start.
/// What the system does not tell is left out.
void add_process(Samples& samples);

}  // namespace sightline::server::metrics

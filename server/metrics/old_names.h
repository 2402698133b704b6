// The names that metrics had before they began with "sightline_". They end with the next version.
#pragma once

#include <prometheus/metric_family.h>

#include <vector>

namespace sightline::server::metrics {

/// Appends a copy of each family of the server's own under its old name, whose help says that it is
/// deprecated and what to use.
void add_old_names(std::vector<prometheus::MetricFamily>& families);

}  // namespace sightline::server::metrics

// The bounds that all histograms of times share.
#pragma once

#include <prometheus/histogram.h>

namespace sightline::server::metrics {

/// Bounds in seconds.
inline const prometheus::Histogram::BucketBoundaries kLatencyBuckets{
    1e-4, 2.5e-4, 5e-4, 1e-3, 2.5e-3, 5e-3, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30};

}  // namespace sightline::server::metrics

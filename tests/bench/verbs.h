// What sightline-bench can measure. Each returns its rows, or the reason why there are none.
#pragma once

#include <vector>

#include "accel/result.h"
#include "tests/bench/options.h"
#include "tests/bench/report.h"

namespace sightline::bench {

// All run on `threads` threads. Errors: kInvalidArgument where the command line is at fault;
// kDataLoss where answers differ from the oracle's or from each other: then no time is given.

/// Writes the rays that scene, kind, count and seed stand for.
Result<std::vector<Row>> run_rays(const CommonOptions& common, const RaysOptions& options);

/// Builds all trees to their end, a row a builder.
Result<std::vector<Row>> run_build(const CommonOptions& common, const BuildOptions& options);

/// Builds and traces, a row a builder. Policy first-touch builds while tracing; the default is
/// full.
Result<std::vector<Row>> run_trace(const CommonOptions& common, const TraceOptions& options);

/// From vertex and index arrays to hits, a row a mode; modes take turns within each repeat.
Result<std::vector<Row>> run_lazy(const CommonOptions& common, const LazyOptions& options);

/// The cost of cutting the scene's box along one axis: rows of what = uniform and adaptive samples,
/// then the suggested and the true curve.
Result<std::vector<Row>> run_curve(const CommonOptions& common, const CurveOptions& options);

}  // namespace sightline::bench

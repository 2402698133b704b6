// What sightline-bench can measure. Each returns its rows, or the reason why there are none.
#pragma once

#include <vector>

#include "accel/result.h"
#include "tests/bench/verbs/options.h"
#include "tests/bench/verbs/report.h"

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

/// Frames of a scene that moves over one that stands still, a row a frame: updating, growing what
/// rays enter, tracing; the last row says what they came to.
Result<std::vector<Row>> run_dynamic(const CommonOptions& common, const DynamicOptions& options);

/// The same rays over a scene that is held in one tree and in two, a row a way; trees are grown
/// before. Ways take turns within each repeat.
Result<std::vector<Row>> run_two_trees(const CommonOptions& common, const TwoTreesOptions& options);

/// Touches of trees that windows of rays grow on gen:terrain, over triangles and triangles seen,
/// and the law fitted to them; of one scene (--scene) instead: runs held against the soup.
Result<std::vector<Row>> run_law(const CommonOptions& common, const LawOptions& options);

/// Touches and the time to the first hit of one view of ever larger hierarchies.
Result<std::vector<Row>> run_law_nodes(const CommonOptions& common, const LawOptions& options);

/// Boxes a second of each inner loop of scan building, on one thread, a row a loop and list.
Result<std::vector<Row>> run_kernel(const CommonOptions& common, const KernelOptions& options);

/// The cost of cutting the scene's box along one axis: rows of what = uniform and adaptive samples,
/// then the suggested and the true curve.
Result<std::vector<Row>> run_curve(const CommonOptions& common, const CurveOptions& options);

/// Rays lost, answered twice and answered wrong on closed scenes far from and near the origin, a
/// row a family, kind of rays, method, builder and policy.
Result<std::vector<Row>> run_robust(const CommonOptions& common, const RobustOptions& options);

/// The study of speed against accuracy: builders and their parameters, and time to image,
/// over several scenes. Writes a CSV and plots of it; a row a file written. More errors:
/// kNotFound: a scene; kFailedPrecondition: files that cannot be written.
Result<std::vector<Row>> run_chart(const CommonOptions& common, const ChartOptions& options);

/// Every builder over the meshes at which methods fail (tests/support/hard_meshes.h), trees full
/// and growing: answers against the oracle, and what the trees cost against what they may, a row a
/// family and builder. A failure is a row that is not `ok`, and no error.
Result<std::vector<Row>> run_stability(const CommonOptions& common,
                                       const StabilityOptions& options);

/// A hash of all answer columns of all kinds of query for every way to answer the same rays: every
/// builder and SIMD target, full and growing trees, numbers of threads, orders and batches. Error:
/// kDataLoss, naming the ways whose hashes are not those of the first.
Result<std::vector<Row>> run_answers(const CommonOptions& common, const AnswersOptions& options);
/// It uses so many, whatever the machine has: the caller's tbb::global_control must allow them.
inline constexpr int kMostAnswerThreads = 8;

/// Trace times of the exact hit rule and of a plain float test in the same walk over the same full
/// trees, a row a kind of ray. Times are sums of the least times of short stretches, over which the
/// methods take turns.
Result<std::vector<Row>> run_exactness(const CommonOptions& common,
                                       const ExactnessOptions& options);

}  // namespace sightline::bench

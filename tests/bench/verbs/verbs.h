// The measurements of sightline-bench. Each returns its rows, or an error.
#pragma once

#include <vector>

#include "proto/result.h"
#include "tests/bench/verbs/options.h"
#include "tests/bench/verbs/report.h"

namespace sightline::bench {

// All run on `threads` threads. Errors: kInvalidArgument: the command line is wrong; kDataLoss:
// answers differ from the oracle's or from each other; then no time is reported.

/// Writes the rays that scene, kind, count and seed determine.
Result<std::vector<Row>> run_rays(const CommonOptions& common, const RaysOptions& options);

/// Builds all trees completely, one row a builder.
Result<std::vector<Row>> run_build(const CommonOptions& common, const BuildOptions& options);

/// Builds and traces, one row a builder. Policy first-touch builds while tracing; the default is
/// full.
Result<std::vector<Row>> run_trace(const CommonOptions& common, const TraceOptions& options);

/// From vertex and index arrays to hits, one row a mode; modes take turns within each repeat.
Result<std::vector<Row>> run_lazy(const CommonOptions& common, const LazyOptions& options);

/// From arrays to hits by every policy, one row for each kind of rays, count of rays (powers of
/// ten) and policy; the last row has the worst ratio of demand to the best of the others.
Result<std::vector<Row>> run_competitive(const CommonOptions& common,
                                         const CompetitiveOptions& options);

/// Batches of rays, for a time, at trees that may hold only a share of the bytes of full ones,
/// beside trees that may hold all; one row for each kind of rays. Error: kDataLoss, if a hit
/// differs.
Result<std::vector<Row>> run_budget(const CommonOptions& common, const BudgetOptions& options);

/// Frames of a moving scene over a static one, one row a frame: update, growth on demand, trace.
/// The last row is a summary.
Result<std::vector<Row>> run_dynamic(const CommonOptions& common, const DynamicOptions& options);

/// The same rays over a scene that is held in one tree and in two, one row a way; trees are grown
/// before. Ways take turns within each repeat.
Result<std::vector<Row>> run_two_trees(const CommonOptions& common, const TwoTreesOptions& options);

/// The time of a batch of updates, one row for each size of the scene, layout, kind and size of the
/// batch.
Result<std::vector<Row>> run_updates(const CommonOptions& common, const UpdatesOptions& options);

/// Revisions that move nodes all over a large scene, and casts after each, one row a rule for
/// merging trees. Error: kDataLoss, if answers depend on the rule.
Result<std::vector<Row>> run_scattered(const CommonOptions& common,
                                       const ScatteredOptions& options);

/// Touches of trees that windows of rays grow on gen:terrain, over triangles and triangles seen,
/// and the law fitted to them. With --scene: runs compared with the soup on that scene.
Result<std::vector<Row>> run_law(const CommonOptions& common, const LawOptions& options);

/// Touches and the time to the first hit for one view of larger and larger hierarchies.
Result<std::vector<Row>> run_law_nodes(const CommonOptions& common, const LawOptions& options);

/// What the rule of demand compares (accel/lazy/demand.h), over the scene as one mesh: nanoseconds
/// a reference of searches by one ray, of divisions, and of making leaf blocks; one row each. Run
/// it with one thread.
Result<std::vector<Row>> run_calibrate(const CommonOptions& common);

/// Boxes a second of each inner loop of scan building, on one thread, one row for each loop and
/// list.
Result<std::vector<Row>> run_kernel(const CommonOptions& common, const KernelOptions& options);

/// The cost of splitting the scene's box along one axis: rows of what = uniform and adaptive
/// samples, then the suggested and the true curve.
Result<std::vector<Row>> run_curve(const CommonOptions& common, const CurveOptions& options);

/// Lost, duplicate and wrong hits on closed scenes near the origin and far from it, one row for
/// each family, kind of rays, method, builder and policy.
Result<std::vector<Row>> run_robust(const CommonOptions& common, const RobustOptions& options);

/// The study of speed against accuracy: builders and their parameters, and time to image,
/// over several scenes. Writes a CSV and plots of it; one row for each file written. More errors:
/// kNotFound: a scene; kFailedPrecondition: files that cannot be written.
Result<std::vector<Row>> run_chart(const CommonOptions& common, const ChartOptions& options);

/// All builders over the meshes on which methods fail (tests/support/hard_meshes.h), with full and
/// growing trees: answers against the oracle, and the costs of the trees against their bounds, one
/// row for each family and builder. A failure is a row that is not `ok`, and no error.
Result<std::vector<Row>> run_stability(const CommonOptions& common,
                                       const StabilityOptions& options);

/// Bytes and rays' work of trees over clustered triangles (tests/support/hard_clusters.h), full and
/// growing, one row for each kind; the first is a compact mesh, and work is over that one's.
/// `wrong` are rays whose hits differ between both trees.
Result<std::vector<Row>> run_clusters(const CommonOptions& common, const ClusterOptions& options);

/// One hash of all answer columns of all kinds of query for every way to answer the same rays: all
/// builders and SIMD targets, full and growing trees, numbers of threads, orders and batches.
/// Error: kDataLoss, naming the ways whose hashes differ from the first.
Result<std::vector<Row>> run_answers(const CommonOptions& common, const AnswersOptions& options);
/// Threads that run_answers uses on any machine: the caller's tbb::global_control must allow them.
inline constexpr int kMostAnswerThreads = 8;

/// Casts on a server in a process of its own beside the same rays in process, in turns: a row for
/// each kind of answer, and one for generated rays. `cpu_ns_per_ray` is the processor time of both
/// processes. Every answer is compared first.
Result<std::vector<Row>> run_remote(const CommonOptions& common, const RemoteOptions& options);
Result<std::vector<Row>> run_tick(const CommonOptions& common, const TickOptions& options);

/// The faces nearest to points over full trees, and by Embree's point queries (MEDIUM, ROBUST, a
/// callback in floats) over the same, a row for each kind of points; sums of the least times of
/// chunks, on each of which the two take turns. A part of the answers is checked by brute force.
Result<std::vector<Row>> run_nearest(const CommonOptions& common, const NearestOptions& options);

/// What points grow by first touch, in counts: as many points near the surface as rays that end
/// there, one row for each number; points within a hundredth of the diagonal around one spot. And
/// the time of one point at a mesh that is not built, which searches it, over that of one ray: one
/// row for each kind of points.
Result<std::vector<Row>> run_lazy_points(const CommonOptions& common,
                                         const LazyPointsOptions& options);

/// Nearest faces and their distances, bit for bit, against the oracle over families of points
/// (tests/support/point_families.h), in every state of the trees, on every SIMD target, for all
/// kinds of query, numbers of threads and sizes of batches, one row for each family. Error:
/// kDataLoss, with the rows, if an answer differs.
Result<std::vector<Row>> run_check(const CommonOptions& common, const CheckOptions& options);

/// Trace times of the exact hit rule and of a plain float test in the same walk over the same full
/// trees, one row for each kind of ray. Times are sums of the least times of short chunks, on each
/// of which the methods take turns.
Result<std::vector<Row>> run_exactness(const CommonOptions& common,
                                       const ExactnessOptions& options);

}  // namespace sightline::bench

// lazy: from vertex and index arrays to hits, growing only what rays enter, or everything first.
#include <algorithm>

#include "tests/bench/hit_hash.h"
#include "tests/bench/tree_figures.h"
#include "tests/bench/verbs.h"
#include "tests/bench/workload.h"

namespace sightline::bench {
namespace {

struct Mode {
  std::string name;
  scenegraph::Growth growth = scenegraph::Growth::kFirstTouch;
  std::vector<double> seconds, build_ms, trace_ms;
  scenegraph::TraceStats stats;
  scenegraph::BuildSummary summary;
  std::string hash;
};

struct Task {
  const SceneSource& scene;
  const std::vector<accel::Ray>& rays;
  accel::AnyBuilder builder;
  std::size_t batch;
  int threads;
};

struct Run {
  std::shared_ptr<const scenegraph::Snapshot> snapshot;
  std::vector<accel::Hit> hits;
};

Status trace_batches(const Task& task, const scenegraph::Snapshot& snapshot,
                     std::span<accel::Hit> hits, scenegraph::TraceStats& stats) {
  const std::span<const accel::Ray> rays(task.rays);
  for (std::size_t first = 0; first < rays.size(); first += task.batch) {
    const std::size_t count = std::min(task.batch, rays.size() - first);
    auto traced = scenegraph::trace(snapshot, rays.subspan(first, count),
                                    hits.subspan(first, count), {.surface = false});
    if (!traced.ok()) return traced.error();
    stats += *traced;
  }
  return {};
}

// Meshes are checked and bounded inside the clock: at its start there is nothing but the arrays.
Result<Run> run_once(const Task& task, Mode& mode) {
  SceneSource arrays = task.scene;
  Run run;
  run.hits.resize(task.rays.size());
  scenegraph::TraceStats stats;

  const Stopwatch clock;
  auto snapshot = assemble(std::move(arrays), task.builder);
  if (!snapshot.ok()) return snapshot.error();
  if (mode.growth == scenegraph::Growth::kFull) {
    auto built = scenegraph::build_all(**snapshot);
    if (!built.ok()) return built.error();
    stats += *built;
  }
  const double before_rays = clock.seconds();
  if (auto s = trace_batches(task, **snapshot, run.hits, stats); !s.ok()) return s.error();
  const double seconds = clock.seconds();

  // What lazy building took of the wall is known only as a share of all threads' time.
  const double build = mode.growth == scenegraph::Growth::kFull
                           ? before_rays
                           : before_rays + stats.build_seconds / task.threads;
  mode.seconds.push_back(seconds);
  mode.build_ms.push_back(build * 1e3);
  mode.trace_ms.push_back((seconds - build) * 1e3);
  mode.stats = stats;
  mode.summary = scenegraph::summarize_build(**snapshot);
  mode.hash = hit_hash(run.hits, scenegraph::QueryKind::kClosest);
  run.snapshot = std::move(snapshot).value();
  return run;
}

Result<std::vector<Mode>> parse_modes(const std::vector<std::string>& names) {
  std::vector<Mode> modes;
  for (const std::string& name : names) {
    Mode mode;
    mode.name = name;
    if (name == "full") {
      mode.growth = scenegraph::Growth::kFull;
    } else if (name != "lazy") {
      return Error{Code::kInvalidArgument, "no mode \"" + name + "\"; there are: lazy full",
                   "MODE"};
    }
    modes.push_back(std::move(mode));
  }
  return modes;
}

Row make_row(const CommonOptions& common, const LazyOptions& options, const Task& task,
             const Mode& mode, std::uint64_t visible) {
  const std::uint64_t total = mode.summary.triangles_total;
  Row row;
  row["scene"] = common.scene;
  row["mode"] = mode.name;
  row["rays"] = options.rays.kind;
  row["count"] = task.rays.size();
  row["threads"] = common.threads;
  set_times(row, "seconds_to_hits", mode.seconds);
  set_times(row, "build_ms", mode.build_ms);
  set_times(row, "trace_ms", mode.trace_ms);
  row["hits"] = mode.stats.hits;
  row["touches"] = mode.stats.touches;
  row["touches_prepare"] = mode.stats.touches_prepare;
  row["cells_expanded"] = mode.stats.cells_expanded;
  row["instances_total"] = mode.summary.instances_total;
  row["instances_entered"] = mode.summary.instances_entered;
  row["triangles_total"] = total;
  row["triangles_touched"] = mode.summary.triangles_built;
  row["visible_fraction"] =
      total > 0 ? static_cast<double>(visible) / static_cast<double>(total) : 0.0;
  row["bytes_final"] = mode.summary.bytes_trees;
  row["hit_hash"] = mode.hash;
  row["traversal_steps"] = mode.stats.traversal_steps;
  row["triangle_tests"] = mode.stats.triangle_tests;
  return row;
}

}  // namespace

Result<std::vector<Row>> run_lazy(const CommonOptions& common, const LazyOptions& options) {
  auto modes = parse_modes(options.modes);
  if (!modes.ok()) return modes.error();
  if (auto p = parse_policy(common.policy, scenegraph::Growth::kFirstTouch); !p.ok()) {
    return p.error();
  }
  const auto builder = configured_builder(options.builder, common);
  if (!builder.ok()) return builder.error();
  const auto scene = make_scene(common);
  if (!scene.ok()) return scene.error();
  const auto rays = make_rays(*scene, options.rays, common.seed);
  if (!rays.ok()) return rays.error();
  const auto check = AnswerCheck::make(*scene, *rays, scenegraph::QueryKind::kClosest);
  if (!check.ok()) return check.error();
  const std::size_t batch =
      options.batch > 0 ? options.batch : std::max<std::size_t>(rays->size(), 1);
  const Task task{*scene, *rays, *builder, batch, common.threads};

  // One full run that is not counted: warms the process and shows what a full tree's rays see.
  Mode unmeasured;
  unmeasured.growth = scenegraph::Growth::kFull;
  auto full = run_once(task, unmeasured);
  if (!full.ok()) return full.error();
  if (auto right = (*check)(full->hits); !right.ok()) return right.error();
  const std::uint64_t visible = visible_triangles(*full->snapshot, *rays, full->hits);
  full->snapshot.reset();

  for (int repeat = 0; repeat < common.repeat; ++repeat) {
    for (Mode& mode : *modes) {
      auto run = run_once(task, mode);
      if (!run.ok()) return run.error();
      if (mode.hash != unmeasured.hash) {
        return Error{Code::kDataLoss,
                     "answers of mode " + mode.name + " (" + mode.hash +
                         ") differ from those of a full tree (" + unmeasured.hash + ")",
                     "HASHES_DIFFER"};
      }
    }
  }
  std::vector<Row> rows;
  for (const Mode& mode : *modes) rows.push_back(make_row(common, options, task, mode, visible));
  return rows;
}

}  // namespace sightline::bench

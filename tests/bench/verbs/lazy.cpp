// lazy: from vertex and index arrays to hits, growing only the cells that rays enter, or all first.
#include <algorithm>

#include "accel/published/any_builder.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/disagreement.h"
#include "tests/bench/verbs/hit_hash.h"
#include "tests/bench/verbs/tree_figures.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

struct Mode {
  std::string name;
  scenegraph::Growth growth = scenegraph::Growth::kFirstTouch;
  std::unique_ptr<EmbreePeer> embree;  // Null: one of our builders
  std::vector<double> seconds, build_ms, trace_ms;
  scenegraph::TraceStats stats;
  scenegraph::revision::BuildSummary summary;
  std::string hash;
  EmbreeGrown embree_grown;
  Disagreement disagreement;
};

struct Task {
  const SceneSource& scene;
  const std::vector<accel::geometry::Ray>& rays;
  accel::published::AnyBuilder builder;
  accel::mesh::References references;
  std::size_t batch;
  int threads;
};

struct Run {
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot;
  std::vector<accel::geometry::Hit> hits;
};

Status trace_batches(const Task& task, const scenegraph::revision::Snapshot& snapshot,
                     scenegraph::Growth growth, std::span<accel::geometry::Hit> hits,
                     scenegraph::TraceStats& stats) {
  const std::span<const accel::geometry::Ray> rays(task.rays);
  for (std::size_t first = 0; first < rays.size(); first += task.batch) {
    const std::size_t count = std::min(task.batch, rays.size() - first);
    auto traced =
        scenegraph::trace(snapshot, rays.subspan(first, count), hits.subspan(first, count),
                          {.growth = growth, .surface = false});
    if (!traced.ok()) return traced.error();
    stats += *traced;
  }
  return {};
}

// Meshes are checked and bounded inside the clock: at its start there are only the arrays.
Result<Run> run_once(const Task& task, Mode& mode) {
  SceneSource arrays = task.scene;
  Run run;
  run.hits.resize(task.rays.size());
  scenegraph::TraceStats stats;

  const Stopwatch clock;
  auto snapshot = assemble(std::move(arrays), task.builder, task.references);
  if (!snapshot.ok()) return snapshot.error();
  if (mode.growth == scenegraph::Growth::kFull) {
    auto built = scenegraph::build_all(**snapshot);
    if (!built.ok()) return built.error();
    stats += *built;
  }
  const double before_rays = clock.seconds();
  const auto growth =
      mode.growth == scenegraph::Growth::kFull ? scenegraph::Growth::kFirstTouch : mode.growth;
  if (auto s = trace_batches(task, **snapshot, growth, run.hits, stats); !s.ok()) return s.error();
  const double seconds = clock.seconds();

  // The wall time of lazy building is only known as a share of all threads' time.
  const double build = mode.growth == scenegraph::Growth::kFull
                           ? before_rays
                           : before_rays + stats.build_seconds / task.threads;
  mode.seconds.push_back(seconds);
  mode.build_ms.push_back(build * 1e3);
  mode.trace_ms.push_back((seconds - build) * 1e3);
  mode.stats = stats;
  mode.summary = scenegraph::revision::summarize_build(**snapshot);
  mode.hash = hit_hash(run.hits, scenegraph::QueryKind::kClosest);
  run.snapshot = *std::move(snapshot);
  return run;
}

// Rays are written into Embree's own layout outside the clock.
Status run_embree(const Task& task, Mode& mode) {
  const auto built = mode.embree->build();
  if (!built.ok()) return built.error();
  std::vector<accel::geometry::Hit> hits(task.rays.size());
  const double trace = mode.embree->trace(task.rays, false, hits, task.batch);
  mode.embree_grown = mode.embree->grown();
  const double seconds = built->total_seconds + trace;
  const double build = built->total_seconds + mode.embree_grown.seconds_in_trace / task.threads;
  mode.seconds.push_back(seconds);
  mode.build_ms.push_back(build * 1e3);
  mode.trace_ms.push_back((seconds - build) * 1e3);
  return {};
}

Result<std::vector<Mode>> parse_modes(const std::vector<std::string>& names,
                                      const SceneSource& scene, int threads) {
  std::vector<Mode> modes;
  for (const std::string& name : names) {
    Mode mode;
    mode.name = name;
    const auto embree = parse_embree(name);
    if (embree || name == kEmbreeLazy) {
      if (embree_is_missing(name)) continue;
      auto peer = embree ? EmbreePeer::make(scene, *embree, threads)
                         : EmbreePeer::make_lazy(scene, threads);
      if (!peer.ok()) return peer.error();
      mode.embree = *std::move(peer);
    } else if (name == "full") {
      mode.growth = scenegraph::Growth::kFull;
    } else if (name == "demand") {
      mode.growth = scenegraph::Growth::kDemand;
    } else if (name == "scan") {
      mode.growth = scenegraph::Growth::kNone;
    } else if (name != "lazy") {
      std::string known = "lazy demand scan full " + std::string(kEmbreeLazy);
      for (const std::string_view peer : embree_names()) known += " " + std::string(peer);
      return Error{Code::kInvalidArgument, "no mode \"" + name + "\"; there are: " + known, "MODE"};
    }
    modes.push_back(std::move(mode));
  }
  return modes;
}

// An untimed run of each of Embree's modes warms it, chooses its entry point, and shows where its
// answers differ from ours.
Status prepare_embree(const Task& task, const Run& ours, std::vector<Mode>& modes) {
  for (Mode& mode : modes) {
    if (!mode.embree) continue;
    if (auto built = mode.embree->build(); !built.ok()) return built.error();
    mode.embree->choose_entry(task.rays, false);
    std::vector<accel::geometry::Hit> hits(task.rays.size());
    mode.embree->trace(task.rays, false, hits, task.batch);
    mode.hash = hit_hash(hits, scenegraph::QueryKind::kClosest);
    for (const accel::geometry::Hit& hit : hits)
      mode.stats.hits += hit.state == accel::geometry::HitState::kHit;
    mode.disagreement = explain(ours.snapshot, task.rays, ours.hits, hits, false);
  }
  return {};
}

Row make_row(const CommonOptions& common, const LazyOptions& options, const Task& task,
             const Mode& mode, std::uint64_t visible) {
  const std::uint64_t total = task.scene.unique_triangles();
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
  row["triangles_total"] = total;
  row["triangles_touched"] =
      mode.embree ? mode.embree_grown.triangles : mode.summary.triangles_built;
  row["visible_fraction"] =
      total > 0 ? static_cast<double>(visible) / static_cast<double>(total) : 0.0;
  row["bytes_final"] = mode.embree ? mode.embree_grown.bytes : mode.summary.bytes_trees;
  row["hit_hash"] = mode.hash;
  if (mode.embree) {
    row["entry"] = mode.embree->entry();
    row["objects_built"] = mode.embree_grown.objects;
    row["differences"] = mode.disagreement.differences;
    row["differences_checked"] = mode.disagreement.checked;
    row["unexplained"] = mode.disagreement.unexplained;
    return row;
  }
  row["touches"] = mode.stats.touches;
  row["touches_prepare"] = mode.stats.touches_prepare;
  row["cells_expanded"] = mode.stats.cells_expanded;
  row["instances_total"] = mode.summary.instances_total;
  row["instances_entered"] = mode.summary.instances_entered;
  row["traversal_steps"] = mode.stats.traversal_steps;
  row["triangle_tests"] = mode.stats.triangle_tests;
  return row;
}

// Medians of the quotients within repeats: the machine's other load affects both sides.
void set_ratios(Row& row, const Mode& mode, const std::vector<Mode>& others) {
  for (const Mode& other : others) {
    if (&other == &mode) continue;
    std::vector<double> quotients;
    for (std::size_t i = 0; i < mode.seconds.size(); ++i) {
      quotients.push_back(mode.seconds[i] / other.seconds[i]);
    }
    std::string key = "over_" + other.name;
    std::replace(key.begin(), key.end(), '-', '_');
    row[key] = median(quotients);
  }
}

}  // namespace

Result<std::vector<Row>> run_lazy(const CommonOptions& common, const LazyOptions& options) {
  if (auto p = parse_policy(common.policy, scenegraph::Growth::kFirstTouch); !p.ok()) {
    return p.error();
  }
  const auto builder = configured_builder(options.builder, common);
  if (!builder.ok()) return builder.error();
  const auto references = parse_hierarchy(options.hierarchy);
  if (!references.ok()) return references.error();
  const auto scene = make_scene(common);
  if (!scene.ok()) return scene.error();
  auto modes = parse_modes(options.modes, *scene, common.threads);
  if (!modes.ok()) return modes.error();
  const auto rays = make_rays(*scene, options.rays, common.seed);
  if (!rays.ok()) return rays.error();
  const auto check = AnswerCheck::make(*scene, *rays, scenegraph::QueryKind::kClosest);
  if (!check.ok()) return check.error();
  const std::size_t batch =
      options.batch > 0 ? options.batch : std::max<std::size_t>(rays->size(), 1);
  const Task task{*scene, *rays, *builder, *references, batch, common.threads};

  // One untimed full run warms the process and shows what rays see in a full tree.
  Mode unmeasured;
  unmeasured.growth = scenegraph::Growth::kFull;
  auto full = run_once(task, unmeasured);
  if (!full.ok()) return full.error();
  if (auto right = (*check)(full->hits); !right.ok()) return right.error();
  const std::uint64_t visible = visible_triangles(*full->snapshot, *rays, full->hits);
  if (auto ready = prepare_embree(task, *full, *modes); !ready.ok()) return ready.error();
  full->snapshot.reset();

  for (int repeat = 0; repeat < common.repeat; ++repeat) {
    for (Mode& mode : *modes) {
      if (mode.embree) {
        if (auto done = run_embree(task, mode); !done.ok()) return done.error();
        continue;
      }
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
  for (const Mode& mode : *modes) {
    rows.push_back(make_row(common, options, task, mode, visible));
    if (mode.name == "lazy" || mode.name == "demand") set_ratios(rows.back(), mode, *modes);
  }
  return rows;
}

}  // namespace sightline::bench

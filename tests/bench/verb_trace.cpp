// trace: how fast rays are answered from a builder's trees.
#include "tests/bench/hit_hash.h"
#include "tests/bench/verbs.h"
#include "tests/bench/workload.h"

namespace sightline::bench {
namespace {

struct Measured {
  std::vector<double> build_ms, trace_ms;
  scenegraph::TraceStats stats;
  std::string hash;
};

struct Task {
  const SceneSource& scene;
  const std::vector<accel::Ray>& rays;
  scenegraph::QueryKind kind;
  scenegraph::Growth growth;
  const AnswerCheck& check;
};

Status measure_once(const Task& task, const accel::AnyBuilder& builder, Measured& measured) {
  auto snapshot = assemble(task.scene, builder);
  if (!snapshot.ok()) return snapshot.error();
  (void)(*snapshot)->instances();
  scenegraph::TraceStats built;
  const Stopwatch build_clock;
  if (task.growth == scenegraph::Growth::kFull) {
    auto all = scenegraph::build_all(**snapshot);
    if (!all.ok()) return all.error();
    built = *all;
  }
  const double build_seconds = build_clock.seconds();

  std::vector<accel::Hit> hits(task.rays.size());
  const Stopwatch trace_clock;
  auto traced = scenegraph::trace(
      **snapshot, task.rays, hits,
      {.kind = task.kind, .growth = scenegraph::Growth::kFirstTouch, .surface = false});
  const double trace_seconds = trace_clock.seconds();
  if (!traced.ok()) return traced.error();

  const std::string hash = hit_hash(hits, task.kind);
  if (!measured.hash.empty() && hash != measured.hash) {
    return Error{Code::kDataLoss, "answers differ between repeats: " + measured.hash + ", " + hash,
                 "HASHES_DIFFER"};
  }
  if (measured.hash.empty()) {
    if (auto right = task.check(hits); !right.ok()) return right.error();
  }
  measured.hash = hash;
  measured.build_ms.push_back(build_seconds * 1e3);
  measured.trace_ms.push_back(trace_seconds * 1e3);
  measured.stats = built;
  measured.stats += *traced;
  return {};
}

Row make_row(const CommonOptions& common, const TraceOptions& options, const Task& task,
             const std::string& builder, const Measured& m) {
  Row row;
  row["scene"] = common.scene;
  row["builder"] = builder;
  row["policy"] = policy_name(task.growth);
  row["rays"] = options.rays.kind;
  row["count"] = task.rays.size();
  row["kind"] = task.kind == scenegraph::QueryKind::kAny ? "any" : "closest";
  row["triangles"] = task.scene.unique_triangles();
  row["threads"] = common.threads;
  set_times(row, "build_ms", m.build_ms);
  set_times(row, "trace_ms", m.trace_ms);
  row["mrays_per_s"] = static_cast<double>(task.rays.size()) / (median(m.trace_ms) * 1e3);
  row["hits"] = m.stats.hits;
  row["hit_hash"] = m.hash;
  row["traversal_steps"] = m.stats.traversal_steps;
  row["triangle_tests"] = m.stats.triangle_tests;
  row["cells_expanded"] = m.stats.cells_expanded;
  row["touches"] = m.stats.touches;
  row["touches_prepare"] = m.stats.touches_prepare;
  return row;
}

}  // namespace

Result<std::vector<Row>> run_trace(const CommonOptions& common, const TraceOptions& options) {
  const auto growth = parse_policy(common.policy, scenegraph::Growth::kFull);
  if (!growth.ok()) return growth.error();
  std::vector<accel::AnyBuilder> builders;
  for (const std::string& name : options.builders) {
    auto builder = configured_builder(name, common);
    if (!builder.ok()) return builder.error();
    builders.push_back(*builder);
  }
  const auto scene = make_scene(common);
  if (!scene.ok()) return scene.error();
  const auto rays = make_rays(*scene, options.rays, common.seed);
  if (!rays.ok()) return rays.error();
  const auto check = AnswerCheck::make(*scene, *rays, options.kind);
  if (!check.ok()) return check.error();
  const Task task{*scene, *rays, options.kind, *growth, *check};

  std::vector<Measured> measured(builders.size());
  for (int repeat = 0; repeat < common.repeat; ++repeat) {
    for (std::size_t b = 0; b < builders.size(); ++b) {
      if (auto s = measure_once(task, builders[b], measured[b]); !s.ok()) return s.error();
      if (measured[b].hash != measured.front().hash) {
        return Error{
            Code::kDataLoss,
            "answers differ between " + options.builders.front() + " and " + options.builders[b],
            "HASHES_DIFFER"};
      }
    }
  }
  std::vector<Row> rows;
  for (std::size_t b = 0; b < builders.size(); ++b) {
    rows.push_back(make_row(common, options, task, options.builders[b], measured[b]));
  }
  return rows;
}

}  // namespace sightline::bench

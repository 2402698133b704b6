// trace: how fast rays are answered from a builder's trees.
#include <optional>

#include "accel/published/any_builder.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/disagreement.h"
#include "tests/bench/verbs/hit_hash.h"
#include "tests/bench/verbs/packed_columns.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

struct Measured {
  std::vector<double> build_ms, trace_ms;
  scenegraph::TraceStats stats;
  std::string hash;
  std::string entry;          // Embree only
  Disagreement disagreement;  // Embree only
};

struct Task {
  const SceneSource& scene;
  const std::vector<accel::geometry::Ray>& rays;
  scenegraph::QueryKind kind;
  scenegraph::Growth growth;
  const AnswerCheck& check;
  PackedColumns* columns = nullptr;  ///< Null: arrays of structs.

  bool any() const { return kind == scenegraph::QueryKind::kAny; }
};

// The reference for Embree's answers: all answers of the default builder's trees.
struct Reference {
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot;
  std::vector<accel::geometry::Hit> hits;
};

/// The hashes of all builders are compared with the first; this one is that of arrays.
Status check_columns(const Task& task, const Reference& reference, const Measured& measured) {
  const std::string expected = hit_hash(reference.hits, task.kind);
  if (task.columns == nullptr || measured.hash == expected) return {};
  return Error{
      Code::kDataLoss,
      "answers in columns, " + measured.hash + ", differ from those in arrays, " + expected,
      "HASHES_DIFFER"};
}

Result<Reference> make_reference(const Task& task) {
  auto snapshot = assemble(task.scene, accel::published::default_builder());
  if (!snapshot.ok()) return snapshot.error();
  Reference reference{*std::move(snapshot), std::vector<accel::geometry::Hit>(task.rays.size())};
  auto traced = scenegraph::trace(*reference.snapshot, task.rays, reference.hits,
                                  {.kind = task.kind, .surface = false});
  if (!traced.ok()) return traced.error();
  if (auto right = task.check(reference.hits); !right.ok()) return right.error();
  return reference;
}

/// Sets `seconds` to the time that the rays took, and `hits` to their answers.
Result<scenegraph::TraceStats> trace_timed(const Task& task,
                                           const scenegraph::revision::Snapshot& snapshot,
                                           std::vector<accel::geometry::Hit>& hits,
                                           double& seconds) {
  const scenegraph::TraceOptions options{
      .kind = task.kind, .growth = scenegraph::Growth::kFirstTouch, .surface = false};
  const Stopwatch clock;
  auto traced = task.columns != nullptr ? scenegraph::trace(snapshot, task.columns->rays(),
                                                            task.columns->fields(), options)
                                        : scenegraph::trace(snapshot, task.rays, hits, options);
  seconds = clock.seconds();
  if (task.columns != nullptr) hits = task.columns->hits();
  return traced;
}

Status measure_ours(const Task& task, const accel::published::AnyBuilder& builder,
                    Measured& measured) {
  auto snapshot = assemble(task.scene, builder);
  if (!snapshot.ok()) return snapshot.error();
  (void)(*snapshot)->trees().static_tree();
  scenegraph::TraceStats built;
  const Stopwatch build_clock;
  if (task.growth == scenegraph::Growth::kFull) {
    auto all = scenegraph::build_all(**snapshot);
    if (!all.ok()) return all.error();
    built = *all;
  }
  const double build_seconds = build_clock.seconds();

  std::vector<accel::geometry::Hit> hits(task.rays.size());
  double trace_seconds = 0;
  const auto traced = trace_timed(task, **snapshot, hits, trace_seconds);
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

Status measure_embree(const Task& task, EmbreePeer& peer, const Reference& reference,
                      Measured& measured) {
  const auto built = peer.build();
  if (!built.ok()) return built.error();
  const bool first = measured.trace_ms.empty();
  if (first) peer.choose_entry(task.rays, task.any());
  std::vector<accel::geometry::Hit> hits(task.rays.size());
  const double trace_seconds = peer.trace(task.rays, task.any(), hits, 0);
  measured.build_ms.push_back(built->commit_seconds * 1e3);
  measured.trace_ms.push_back(trace_seconds * 1e3);
  if (!first) return {};
  measured.entry = peer.entry();
  measured.hash = hit_hash(hits, task.kind);
  for (const accel::geometry::Hit& hit : hits)
    measured.stats.hits += hit.state == accel::geometry::HitState::kHit;
  measured.disagreement = explain(reference.snapshot, task.rays, reference.hits, hits, task.any());
  return {};
}

Row make_row(const CommonOptions& common, const TraceOptions& options, const Task& task,
             const Contender& contender, const Measured& m) {
  const bool ours = contender.ours() != nullptr;
  Row row;
  row["scene"] = common.scene;
  row["builder"] = contender.name;
  row["policy"] = policy_name(ours ? task.growth : scenegraph::Growth::kFull);
  row["rays"] = options.rays.kind;
  row["count"] = task.rays.size();
  row["kind"] = task.any() ? "any" : "closest";
  if (ours && task.columns != nullptr) row["entry"] = "columns";
  row["triangles"] = task.scene.unique_triangles();
  row["threads"] = common.threads;
  set_times(row, "build_ms", m.build_ms);
  set_times(row, "trace_ms", m.trace_ms);
  row["mrays_per_s"] = static_cast<double>(task.rays.size()) / (median(m.trace_ms) * 1e3);
  row["hits"] = m.stats.hits;
  row["hit_hash"] = m.hash;
  if (!ours) {
    row["entry"] = m.entry;
    row["differences"] = m.disagreement.differences;
    row["differences_checked"] = m.disagreement.checked;
    row["unexplained"] = m.disagreement.unexplained;
    return row;
  }
  row["traversal_steps"] = m.stats.traversal_steps;
  row["triangle_tests"] = m.stats.triangle_tests;
  row["cells_expanded"] = m.stats.cells_expanded;
  row["touches"] = m.stats.touches;
  row["touches_prepare"] = m.stats.touches_prepare;
  return row;
}

Status compare_hashes(const std::vector<Contender>& contenders,
                      const std::vector<Measured>& measured) {
  std::size_t first = contenders.size();
  for (std::size_t b = 0; b < contenders.size(); ++b) {
    if (contenders[b].ours() == nullptr || measured[b].hash.empty()) continue;
    if (first == contenders.size()) first = b;
    if (measured[b].hash == measured[first].hash) continue;
    return Error{Code::kDataLoss,
                 "answers differ between " + contenders[first].name + " and " + contenders[b].name,
                 "HASHES_DIFFER"};
  }
  return {};
}

}  // namespace

Result<std::vector<Row>> run_trace(const CommonOptions& common, const TraceOptions& options) {
  const auto growth = parse_policy(common.policy, scenegraph::Growth::kFull);
  if (!growth.ok()) return growth.error();
  const auto contenders = parse_contenders(options.builders, common);
  if (!contenders.ok()) return contenders.error();
  const auto scene = make_scene(common);
  if (!scene.ok()) return scene.error();
  const auto rays = make_rays(*scene, options.rays, common.seed);
  if (!rays.ok()) return rays.error();
  const auto check = AnswerCheck::make(*scene, *rays, options.kind);
  if (!check.ok()) return check.error();
  std::optional<PackedColumns> columns;
  if (options.columns) columns.emplace(*rays, options.kind);
  const Task task{*scene, *rays, options.kind, *growth, *check, columns ? &*columns : nullptr};
  const auto peers = open_peers(*contenders, *scene, common.threads);
  if (!peers.ok()) return peers.error();
  const auto reference = make_reference(task);
  if (!reference.ok()) return reference.error();

  std::vector<Measured> measured(contenders->size());
  for (int repeat = 0; repeat < common.repeat; ++repeat) {
    for (std::size_t b = 0; b < contenders->size(); ++b) {
      const accel::published::AnyBuilder* ours = (*contenders)[b].ours();
      const Status done = ours != nullptr
                              ? measure_ours(task, *ours, measured[b])
                              : measure_embree(task, *(*peers)[b], *reference, measured[b]);
      if (!done.ok()) {
        return Error{done.error().code, (*contenders)[b].name + ": " + done.error().message,
                     done.error().reason};
      }
      if (ours == nullptr) continue;
      if (auto same = check_columns(task, *reference, measured[b]); !same.ok()) return same.error();
    }
    if (auto same = compare_hashes(*contenders, measured); !same.ok()) return same.error();
  }
  std::vector<Row> rows;
  for (std::size_t b = 0; b < contenders->size(); ++b) {
    rows.push_back(make_row(common, options, task, (*contenders)[b], measured[b]));
  }
  return rows;
}

}  // namespace sightline::bench

// How fast each builder is, and what its tree costs to trace.
#include "tests/bench/charts/builders.h"
#include "accel/published/any_builder.h"

#include <array>
#include <map>
#include <memory>
#include <string>

#include "tests/bench/charts/builder_rows.h"
#include "tests/bench/verbs/disagreement.h"
#include "tests/bench/verbs/hit_hash.h"
#include "tests/bench/verbs/tree_figures.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;
using SnapshotPtr = std::shared_ptr<const scenegraph::revision::Snapshot>;

Result<SnapshotPtr> built_tree(const SceneSource& scene,
                               const accel::published::AnyBuilder& builder,
                               ChartMeasured& measured) {
  auto snapshot = assemble(scene, builder);
  if (!snapshot.ok()) return snapshot.error();
  (void)(*snapshot)->trees().static_tree();
  const Stopwatch clock;
  auto built = scenegraph::build_all(**snapshot);
  const double seconds = clock.seconds();
  if (!built.ok()) return built.error();
  measured.build_ms.push_back(seconds * 1e3);
  measured.touches = built->touches;
  if (!measured.metrics) measured.metrics = measure_meshes(**snapshot);
  return snapshot;
}

// The rays of one kind, and their checked answers.
struct View {
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  std::string hash;
};

class BuilderStudy {
 public:
  static Result<BuilderStudy> make(const SceneSource& scene, std::uint64_t seed, std::size_t rays) {
    BuilderStudy study(scene);
    ChartMeasured warm;  // The first run warms caches, the allocator and threads; it is not timed.
    auto reference = built_tree(scene, accel::published::default_builder(), warm);
    if (!reference.ok()) return reference.error();
    study.reference_ = *std::move(reference);
    for (std::size_t k = 0; k < kChartRays.size(); ++k) {
      const RayOptions kind{std::string(kChartRays[k]), rays};
      if (auto made = study.add_view(k, kind, seed); !made.ok()) return made.error();
    }
    return study;
  }

  Status measure(const ChartContender& contender, int threads, ChartMeasured& measured) {
    return contender.contender.ours() != nullptr ? measure_ours(contender, measured)
                                                 : measure_embree(contender, threads, measured);
  }

 private:
  explicit BuilderStudy(const SceneSource& scene) : scene_(&scene) {}

  Status add_view(std::size_t k, const RayOptions& kind, std::uint64_t seed) {
    auto rays = make_rays(*scene_, kind, seed);
    if (!rays.ok()) return rays.error();
    View& view = views_[k];
    view.rays = *std::move(rays);
    const auto check = AnswerCheck::make(*scene_, view.rays, scenegraph::QueryKind::kClosest);
    if (!check.ok()) return check.error();
    view.hits.resize(view.rays.size());
    auto traced = scenegraph::trace(*reference_, view.rays, view.hits, {.surface = false});
    if (!traced.ok()) return traced.error();
    view.hash = hit_hash(view.hits, scenegraph::QueryKind::kClosest);
    return (*check)(view.hits);
  }

  Status measure_ours(const ChartContender& contender, ChartMeasured& measured) {
    SnapshotPtr& kept = kept_[contender.configuration.text];
    SnapshotPtr snapshot = kept;
    if (!snapshot) {
      auto built = built_tree(*scene_, *contender.contender.ours(), measured);
      if (!built.ok()) return built.error();
      snapshot = *std::move(built);
      if (contender.configuration.built_once) kept = snapshot;
    }
    for (std::size_t k = 0; k < views_.size(); ++k) {
      const View& view = views_[k];
      std::vector<Hit> hits(view.rays.size());
      const Stopwatch clock;
      auto traced = scenegraph::trace(*snapshot, view.rays, hits, {.surface = false});
      const double seconds = clock.seconds();
      if (!traced.ok()) return traced.error();
      ChartTraced& figures = measured.by_rays[k];
      figures.trace_ms.push_back(seconds * 1e3);
      figures.steps = traced->traversal_steps;
      figures.tests = traced->triangle_tests;
      figures.hash = hit_hash(hits, scenegraph::QueryKind::kClosest);
      if (figures.hash == view.hash) continue;
      return Error{Code::kDataLoss,
                   "answers to " + std::string(kChartRays[k]) + " rays (" + figures.hash +
                       ") differ from those of the default builder (" + view.hash + ")",
                   "HASHES_DIFFER"};
    }
    return {};
  }

  Status measure_embree(const ChartContender& contender, int threads, ChartMeasured& measured) {
    auto& peer = peers_[contender.configuration.text];
    const bool first = !peer;
    if (first) {
      auto made = EmbreePeer::make(*scene_, *contender.contender.embree(), threads);
      if (!made.ok()) return made.error();
      peer = *std::move(made);
      if (auto warm = peer->build(); !warm.ok()) return warm.error();
    }
    const auto built = peer->build();
    if (!built.ok()) return built.error();
    measured.build_ms.push_back(built->commit_seconds * 1e3);
    measured.bytes = built->bytes_final;
    for (std::size_t k = 0; k < views_.size(); ++k) {
      const View& view = views_[k];
      std::vector<Hit> hits(view.rays.size());
      peer->choose_entry(view.rays, false);
      ChartTraced& figures = measured.by_rays[k];
      figures.trace_ms.push_back(peer->trace(view.rays, false, hits, 0) * 1e3);
      if (!first) continue;
      figures.hash = hit_hash(hits, scenegraph::QueryKind::kClosest);
      figures.unexplained = explain(reference_, view.rays, view.hits, hits, false).unexplained;
    }
    return {};
  }

  const SceneSource* scene_;
  SnapshotPtr reference_;
  std::array<View, kChartRays.size()> views_;
  std::map<std::string, SnapshotPtr> kept_;
  std::map<std::string, std::unique_ptr<EmbreePeer>> peers_;
};

}  // namespace

Result<std::vector<Row>> chart_builders(const ChartScene& scene,
                                        const std::vector<ChartContender>& contenders,
                                        const CommonOptions& common, const ChartPlan& plan) {
  auto study = BuilderStudy::make(scene.mesh, common.seed, plan.rays);
  if (!study.ok()) return study.error();
  std::vector<ChartMeasured> measured(contenders.size());
  for (int round = 0; round < common.repeat; ++round) {
    for (std::size_t i = 0; i < contenders.size(); ++i) {
      const std::size_t c = round % 2 == 0 ? i : contenders.size() - 1 - i;
      if (auto done = study->measure(contenders[c], common.threads, measured[c]); !done.ok()) {
        return Error{done.error().code,
                     contenders[c].configuration.text + ": " + done.error().message,
                     done.error().reason};
      }
    }
  }
  return chart_builder_rows(scene, contenders, measured, plan.rays);
}

}  // namespace sightline::bench

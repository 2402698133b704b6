// build: how fast a builder is, and what its trees are like.
#include <algorithm>
#include <variant>

#include "tests/bench/memory_peak.h"
#include "tests/bench/tree_figures.h"
#include "tests/bench/verbs.h"
#include "tests/bench/workload.h"

namespace sightline::bench {
namespace {

// Warms caches, the allocator and the worker threads, so that no builder pays for being first.
Status warm_up(const SceneSource& scene, const accel::AnyBuilder& builder) {
  auto snapshot = assemble(scene, builder);
  if (!snapshot.ok()) return snapshot.error();
  if (auto built = scenegraph::build_all(**snapshot); !built.ok()) return built.error();
  return {};
}

struct Measured {
  std::vector<double> build_ms;
  std::uint64_t bytes_peak = 0;
  scenegraph::TraceStats stats;
  accel::TreeMetrics metrics;
};

Status measure_once(const SceneSource& scene, const accel::AnyBuilder& builder,
                    Measured& measured) {
  auto snapshot = assemble(scene, builder);
  if (!snapshot.ok()) return snapshot.error();
  (void)(*snapshot)->instances();
  const MemoryPeak peak;
  const Stopwatch clock;
  auto built = scenegraph::build_all(**snapshot);
  const double seconds = clock.seconds();
  const auto bytes = peak.bytes();
  if (!built.ok()) return built.error();
  measured.build_ms.push_back(seconds * 1e3);
  measured.stats = *built;
  measured.metrics = measure_meshes(**snapshot);
  // Small trees come out of memory that the process holds already.
  measured.bytes_peak = std::max({measured.bytes_peak, bytes.value_or(0), measured.metrics.bytes});
  return {};
}

}  // namespace

Result<std::vector<Row>> run_build(const CommonOptions& common, const BuildOptions& options) {
  // A build is always full; the flag is still checked, as in every verb.
  if (auto p = parse_policy(common.policy, scenegraph::Growth::kFull); !p.ok()) return p.error();
  std::vector<accel::AnyBuilder> builders;
  for (const std::string& name : options.builders) {
    auto builder = configured_builder(name, common);
    if (!builder.ok()) return builder.error();
    builders.push_back(*builder);
  }
  const auto scene = make_scene(common);
  if (!scene.ok()) return scene.error();
  if (auto warm = warm_up(*scene, builders.front()); !warm.ok()) return warm.error();

  std::vector<Measured> measured(builders.size());
  for (int repeat = 0; repeat < common.repeat; ++repeat) {
    for (std::size_t b = 0; b < builders.size(); ++b) {
      if (auto s = measure_once(*scene, builders[b], measured[b]); !s.ok()) return s.error();
    }
  }

  std::vector<Row> rows;
  const std::uint64_t triangles = scene->unique_triangles();
  for (std::size_t b = 0; b < builders.size(); ++b) {
    const Measured& m = measured[b];
    Row row;
    row["scene"] = common.scene;
    row["builder"] = options.builders[b];
    row["triangles"] = triangles;
    row["threads"] = common.threads;
    set_times(row, "build_ms", m.build_ms);
    row["mtris_per_s"] = static_cast<double>(triangles) / (median(m.build_ms) * 1e3);
    const accel::SahConstants cost = std::visit([](const auto& v) { return v.cost; }, builders[b]);
    row["cost_traverse"] = cost.traverse;
    row["cost_intersect"] = cost.intersect;
    set_metrics(row, m.metrics);
    row["bytes_peak"] = m.bytes_peak;
    row["touches"] = m.stats.touches;
    row["touches_prepare"] = m.stats.touches_prepare;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace sightline::bench

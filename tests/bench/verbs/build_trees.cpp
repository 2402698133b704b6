// build: how fast a builder is, and the properties of its trees.
#include <algorithm>
#include <optional>

#include "accel/published/any_builder.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/memory_peak.h"
#include "tests/bench/verbs/tree_figures.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

struct Measured {
  std::vector<double> build_ms;
  std::uint64_t bytes_final = 0, bytes_peak = 0;
  scenegraph::TraceStats stats;
  accel::kdtree::TreeMetrics metrics;
  std::optional<double> end_points;
};

// Traces a few rays through every new tree: a builder with wrong answers gets no time.
class Sample {
 public:
  static Result<Sample> make(const SceneSource& scene, std::uint64_t seed) {
    constexpr std::size_t kRays = 100;
    auto rays = make_rays(scene, {.kind = "random", .count = kRays}, seed);
    // A scene without triangles has no rays to check.
    if (!rays.ok() && rays.error().code == Code::kFailedPrecondition)
      rays = std::vector<accel::geometry::Ray>{};
    if (!rays.ok()) return rays.error();
    auto check = AnswerCheck::make(scene, *rays, scenegraph::QueryKind::kClosest);
    if (!check.ok()) return check.error();
    return Sample(*std::move(rays), *std::move(check));
  }

  Status check(const scenegraph::revision::Snapshot& snapshot) const {
    std::vector<accel::geometry::Hit> hits(rays_.size());
    auto traced = scenegraph::trace(snapshot, rays_, hits,
                                    {.growth = scenegraph::Growth::kNone, .surface = false});
    return traced.ok() ? check_(hits) : traced.error();
  }

 private:
  Sample(std::vector<accel::geometry::Ray> rays, AnswerCheck check)
      : rays_(std::move(rays)), check_(std::move(check)) {}
  std::vector<accel::geometry::Ray> rays_;
  AnswerCheck check_;
};

// Warms caches, the allocator and the worker threads, so that the first builder has no
// disadvantage.
Status warm_up(const SceneSource& scene, const std::vector<Contender>& contenders) {
  for (const Contender& contender : contenders) {
    if (contender.ours() == nullptr) continue;
    auto snapshot = assemble(scene, *contender.ours());
    if (!snapshot.ok()) return snapshot.error();
    if (auto built = scenegraph::build_all(**snapshot); !built.ok()) return built.error();
    break;
  }
  return {};
}

Status measure_ours(const SceneSource& scene, const accel::published::AnyBuilder& builder,
                    const Sample& sample, bool end_points, Measured& measured) {
  auto snapshot = assemble(scene, builder);
  if (!snapshot.ok()) return snapshot.error();
  (void)(*snapshot)->trees().static_tree();
  const MemoryPeak peak;
  const Stopwatch clock;
  auto built = scenegraph::build_all(**snapshot);
  const double seconds = clock.seconds();
  const auto bytes = peak.bytes();
  if (!built.ok()) return built.error();
  if (measured.build_ms.empty()) {
    if (auto right = sample.check(**snapshot); !right.ok()) return right.error();
    if (end_points) measured.end_points = end_point_overlap(**snapshot);
  }
  measured.build_ms.push_back(seconds * 1e3);
  measured.stats = *built;
  measured.metrics = measure_meshes(**snapshot);
  measured.bytes_final = measured.metrics.bytes;
  // Small trees fit into memory that the process already holds.
  measured.bytes_peak = std::max({measured.bytes_peak, bytes.value_or(0), measured.metrics.bytes});
  return {};
}

Status measure_embree(EmbreePeer& peer, Measured& measured) {
  const auto built = peer.build();
  if (!built.ok()) return built.error();
  measured.build_ms.push_back(built->commit_seconds * 1e3);
  measured.bytes_final = built->bytes_final;
  measured.bytes_peak = std::max(measured.bytes_peak, built->bytes_peak);
  return {};
}

Row make_row(const CommonOptions& common, const Contender& contender, std::uint64_t triangles,
             const Measured& m) {
  Row row;
  row["scene"] = common.scene;
  row["builder"] = contender.name;
  row["triangles"] = triangles;
  row["threads"] = common.threads;
  set_times(row, "build_ms", m.build_ms);
  row["mtris_per_s"] = static_cast<double>(triangles) / (median(m.build_ms) * 1e3);
  if (contender.ours() != nullptr) {
    if (const auto costs = build_costs(*contender.ours())) {
      row["cost_traverse"] = costs->traverse;
      row["cost_intersect"] = costs->intersect;
    } else {
      row["cost_traverse"] = row["cost_intersect"] = nullptr;
    }
    set_metrics(row, m.metrics);
    if (m.end_points) row["end_point_overlap"] = *m.end_points;
  } else {
    row["timed"] = "rtcCommitScene";
    row["bytes_final"] = m.bytes_final;
  }
  row["bytes_peak"] = m.bytes_peak;
  if (contender.ours() != nullptr) {
    row["touches"] = m.stats.touches;
    row["touches_prepare"] = m.stats.touches_prepare;
  }
  return row;
}

}  // namespace

Result<std::vector<Row>> run_build(const CommonOptions& common, const BuildOptions& options) {
  // A build is always full, but the flag is checked as in every verb.
  if (auto p = parse_policy(common.policy, scenegraph::Growth::kFull); !p.ok()) return p.error();
  const auto contenders = parse_contenders(options.builders, common);
  if (!contenders.ok()) return contenders.error();
  const auto scene = make_scene(common);
  if (!scene.ok()) return scene.error();
  const auto sample = Sample::make(*scene, common.seed);
  if (!sample.ok()) return sample.error();
  if (auto warm = warm_up(*scene, *contenders); !warm.ok()) return warm.error();
  const auto peers = open_peers(*contenders, *scene, common.threads);
  if (!peers.ok()) return peers.error();

  std::vector<Measured> measured(contenders->size());
  for (int repeat = 0; repeat < common.repeat; ++repeat) {
    for (std::size_t b = 0; b < contenders->size(); ++b) {
      const accel::published::AnyBuilder* ours = (*contenders)[b].ours();
      const Status done =
          ours != nullptr ? measure_ours(*scene, *ours, *sample, options.end_points, measured[b])
                          : measure_embree(*(*peers)[b], measured[b]);
      if (!done.ok()) {
        return Error{done.error().code, (*contenders)[b].name + ": " + done.error().message,
                     done.error().reason};
      }
    }
  }
  std::vector<Row> rows;
  for (std::size_t b = 0; b < contenders->size(); ++b) {
    rows.push_back(make_row(common, (*contenders)[b], scene->unique_triangles(), measured[b]));
  }
  return rows;
}

}  // namespace sightline::bench

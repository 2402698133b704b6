// lazy-points: what points build and search in trees that grow, beside rays.
#include <algorithm>
#include <vector>

#include "tests/bench/scenes/point_kinds.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;
using accel::geometry::Vec3d;
using scenegraph::Growth;
using SnapshotPtr = std::shared_ptr<const scenegraph::revision::Snapshot>;

constexpr std::size_t kBatch = 8192;

class LazyPoints {
 public:
  LazyPoints(const CommonOptions& common, const SceneSource& scene,
             const accel::published::AnyBuilder& builder, SnapshotPtr full)
      : common_(common), scene_(scene), builder_(builder), full_(std::move(full)), kinds_(*full_) {}

  /// As many points near the surface as rays that end there.
  Result<Row> touches(std::size_t count) const {
    const auto ends = ends_of_rays(count);
    if (!ends.ok()) return ends.error();
    tests::Random random(common_.seed);
    std::vector<Ray> points;
    for (const Vec3d& end : ends->at) points.push_back(question_at(kinds_.near(end, random)));
    const auto by_points = grown(points, true), by_rays = grown(ends->rays, false);
    if (!by_points.ok()) return by_points.error();
    if (!by_rays.ok()) return by_rays.error();
    Row row = row_of("touches of points over rays", points.size(), *by_points);
    row["rays_touches_per_triangle"] = per_triangle(by_rays->stats);
    row["over_rays"] = per_triangle(by_points->stats) / per_triangle(by_rays->stats);
    return row;
  }

  /// Points within a hundredth of the diagonal around one spot.
  Result<Row> spot(std::size_t count) const {
    tests::Random random(common_.seed);
    const Vec3d center = kinds_.on_surface(random);
    std::vector<Ray> points;
    while (points.size() < count) {
      const Vec3d off{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
      if (length(off) <= 1) points.push_back(question_at(center + off * (0.01 * diagonal())));
    }
    const auto by_points = grown(points, true);
    if (!by_points.ok()) return by_points.error();
    return row_of("around one spot", count, *by_points);
  }

  /// The time of one point over that of one ray, each at a mesh that is not built.
  Result<Row> cold(const std::string& kind, std::size_t repeats) const {
    const auto ends = ends_of_rays(repeats);
    if (!ends.ok()) return ends.error();
    tests::Random random(common_.seed);
    std::vector<double> of_points, of_rays, quotients;
    for (const Ray& ray : ends->rays) {
      const auto point = seconds(question_at(kinds_.make(kind, random)), true);
      const auto other = seconds(ray, false);
      if (!point.ok()) return point.error();
      if (!other.ok()) return other.error();
      of_points.push_back(*point);
      of_rays.push_back(*other);
      quotients.push_back(*point / *other);
    }
    Row row;
    row["what"] = "one " + kind + " point at a mesh that is not built";
    row["count"] = quotients.size();
    row["point_ns_per_triangle"] = median(of_points) * 1e9 / triangles();
    row["ray_ns_per_triangle"] = median(of_rays) * 1e9 / triangles();
    row["over_rays"] = median(quotients);
    return row;
  }

 private:
  struct Ends {
    std::vector<Ray> rays;
    std::vector<Vec3d> at;
  };
  struct Grown {
    scenegraph::TraceStats stats;
    scenegraph::revision::BuildSummary summary;
  };

  double diagonal() const { return kinds_.diagonal(); }
  double triangles() const { return static_cast<double>(scene_.unique_triangles()); }
  double per_triangle(const scenegraph::TraceStats& stats) const {
    return static_cast<double>(stats.touches + stats.touches_prepare) / triangles();
  }

  /// Random rays that hit something.
  Result<Ends> ends_of_rays(std::size_t count) const {
    const auto rays = make_rays(scene_, {"random", 8 * count + 64}, common_.seed);
    if (!rays.ok()) return rays.error();
    std::vector<Hit> hits(rays->size());
    const auto traced = scenegraph::trace(*full_, *rays, hits, {.surface = false});
    if (!traced.ok()) return traced.error();
    Ends ends;
    for (std::size_t i = 0; i < hits.size() && ends.at.size() < count; ++i) {
      if (hits[i].state != HitState::kHit) continue;
      ends.rays.push_back((*rays)[i]);
      ends.at.push_back((*rays)[i].origin + (*rays)[i].direction * hits[i].t);
    }
    return ends;
  }

  /// What questions grow in trees that are fresh.
  Result<Grown> grown(const std::vector<Ray>& questions, bool points) const {
    const auto snapshot = assemble(scene_, builder_);
    if (!snapshot.ok()) return snapshot.error();
    Grown result;
    std::vector<Hit> hits(questions.size());
    for (std::size_t first = 0; first < questions.size(); first += kBatch) {
      const std::size_t count = std::min(kBatch, questions.size() - first);
      const auto traced = scenegraph::trace(**snapshot, std::span(questions).subspan(first, count),
                                            std::span(hits).subspan(first, count),
                                            {.surface = false, .points = points});
      if (!traced.ok()) return traced.error();
      result.stats += *traced;
    }
    result.summary = scenegraph::revision::summarize_build(**snapshot);
    return result;
  }

  Result<double> seconds(const Ray& question, bool points) const {
    const auto snapshot = assemble(scene_, builder_);
    if (!snapshot.ok()) return snapshot.error();
    Hit hit;
    const Stopwatch clock;
    const auto traced =
        scenegraph::trace(**snapshot, std::span(&question, 1), std::span(&hit, 1),
                          {.growth = Growth::kDemand, .surface = false, .points = points});
    if (!traced.ok()) return traced.error();
    return clock.seconds();
  }

  Row row_of(const std::string& what, std::size_t count, const Grown& grown) const {
    Row row;
    row["what"] = what;
    row["count"] = count;
    row["touches_per_triangle"] = per_triangle(grown.stats);
    row["cells_expanded"] = grown.stats.cells_expanded;
    row["share_built"] = static_cast<double>(grown.summary.triangles_built) / triangles();
    return row;
  }

  const CommonOptions& common_;
  const SceneSource& scene_;
  const accel::published::AnyBuilder& builder_;
  const SnapshotPtr full_;
  const PointKinds kinds_;
};

}  // namespace

Result<std::vector<Row>> run_lazy_points(const CommonOptions& common,
                                         const LazyPointsOptions& options) {
  const auto scene = make_scene(common);
  if (!scene.ok()) return scene.error();
  const auto builder = configured_builder("", common);
  if (!builder.ok()) return builder.error();
  const auto full = assemble(*scene, *builder);
  if (!full.ok()) return full.error();
  if (const auto built = scenegraph::build_all(**full); !built.ok()) return built.error();
  const LazyPoints lazy(common, *scene, *builder, *full);
  std::vector<Row> rows;
  const auto add = [&](Result<Row> row) -> Status {
    if (!row.ok()) return row.error();
    (*row)["scene"] = common.scene;
    rows.push_back(*std::move(row));
    return {};
  };
  for (const std::size_t count : options.counts) {
    if (const Status added = add(lazy.touches(count)); !added) return added.error();
  }
  if (const Status added = add(lazy.spot(options.spot)); !added) return added.error();
  for (const char* const kind : {"near", "volume", "far"}) {
    if (const Status added = add(lazy.cold(kind, options.cold)); !added) return added.error();
  }
  return rows;
}

}  // namespace sightline::bench

// nearest: the faces nearest to points, beside Embree's point queries.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "scenegraph/query/point_order.h"
#include "scenegraph/sides.h"
#include "tests/bench/scenes/point_kinds.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"
#include "tests/support/brute_nearest.h"

namespace sightline::bench {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;
using accel::geometry::Vec3d;

/// Points are timed in chunks, on each of which both take turns.
constexpr std::size_t kChunk = 8'000;
/// Answers that the oracle checks.
constexpr std::size_t kChecked = 500;

Status check(const tests::BruteNearest& oracle, std::span<const Vec3d> points,
             std::span<const Hit> hits) {
  const auto expected = oracle.closest(points, std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool right = expected[i] && hits[i].t == expected[i]->distance &&
                       hits[i].node == expected[i]->node &&
                       hits[i].primitive == expected[i]->primitive;
    if (!right)
      return Error{Code::kDataLoss, "point " + std::to_string(i) + " has another nearest face",
                   "WRONG_ANSWER"};
  }
  return {};
}

struct Times {
  double ours = 0, sides = 0, embree = 0;
  scenegraph::TraceStats stats;  // of one pass over all points
};

double per_point(std::uint64_t number, std::size_t points) {
  return static_cast<double>(number) / static_cast<double>(points);
}

/// The points along the curve that batches of points are sorted by.
std::vector<Vec3d> sorted(std::span<const Vec3d> points) {
  std::vector<Ray> rays;
  for (const Vec3d& p : points) rays.push_back({.origin = p, .direction = {1, 0, 0}});
  const scenegraph::query::OrderedPoints ordered(
      accel::geometry::columns_of(std::span<const Ray>(rays)));
  std::vector<Vec3d> result;
  for (const std::uint32_t i : ordered.order) result.push_back(points[i]);
  return result;
}

/// Seconds for all points, the least of each chunk. Sides are those of one parity ray.
Times measure(const scenegraph::revision::Snapshot& snapshot, EmbreePeer* embree,
              std::span<const Vec3d> points, int repeat, std::span<Hit> ours,
              std::span<Hit> theirs) {
  std::vector<Ray> rays;
  for (const Vec3d& p : points) rays.push_back(question_at(p));
  scenegraph::TraceOptions options;
  options.points = true;
  options.surface = false;
  Times sum;
  std::vector<scenegraph::Side> sides;
  for (std::size_t first = 0; first < points.size(); first += kChunk) {
    const std::size_t count = std::min(kChunk, points.size() - first);
    Times least{HUGE_VAL, HUGE_VAL, HUGE_VAL, {}};
    sides.resize(count);
    const auto chunk =
        accel::geometry::columns_of(std::span<const Ray>(rays).subspan(first, count));
    for (int i = 0; i <= repeat; ++i) {
      const Stopwatch clock;
      const auto traced = scenegraph::trace(snapshot, std::span(rays).subspan(first, count),
                                            ours.subspan(first, count), options);
      least.ours = std::min(least.ours, clock.seconds());
      if (traced && i == 0) sum.stats += *traced;
      const Stopwatch of_sides;
      const auto found = scenegraph::find_sides(snapshot, chunk, {}, {.sides = sides}, options);
      if (found) least.sides = std::min(least.sides, of_sides.seconds());
      if (embree == nullptr) continue;
      least.embree = std::min(least.embree, embree->nearest(points.subspan(first, count),
                                                            theirs.subspan(first, count)));
    }
    sum.ours += least.ours;
    sum.sides += least.sides;
    sum.embree += least.embree;
  }
  return sum;
}

}  // namespace

Result<std::vector<Row>> run_nearest(const CommonOptions& common, const NearestOptions& options) {
  const auto scene = make_scene(common);
  if (!scene.ok()) return scene.error();
  const auto builder = configured_builder("", common);
  if (!builder.ok()) return builder.error();
  const auto snapshot = assemble(*scene, *builder);
  if (!snapshot.ok()) return snapshot.error();
  if (const auto built = scenegraph::build_all(**snapshot); !built.ok()) return built.error();
  std::unique_ptr<EmbreePeer> embree;
  if (embree_found()) {
    auto peer = EmbreePeer::make(*scene, {.robust = true}, common.threads);
    if (!peer.ok()) return peer.error();
    embree = *std::move(peer);
    if (const auto built = embree->build(); !built.ok()) return built.error();
  }
  const PointKinds kinds(**snapshot);
  const tests::BruteNearest oracle(kinds.meshes());
  std::vector<Row> rows;
  for (const std::string& kind : options.kinds) {
    tests::Random random(common.seed);
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < options.count; ++i) points.push_back(kinds.make(kind, random));
    if (options.sorted) points = sorted(points);
    std::vector<Hit> ours(points.size()), theirs(points.size());
    const Times times = measure(**snapshot, embree.get(), points, common.repeat, ours, theirs);
    const std::size_t checked = std::min(kChecked, points.size());
    if (const Status right = check(oracle, std::span(points).first(checked), ours); !right)
      return right.error();
    Row row;
    row["scene"] = common.scene;
    row["points"] = kind;
    row["order"] = options.sorted ? "sorted" : "random";
    row["count"] = points.size();
    row["threads"] = common.threads;
    row["mpoints_per_s"] = static_cast<double>(points.size()) / times.ours * 1e-6;
    row["signed_over_unsigned"] = 1 + times.sides / times.ours;
    row["steps_per_point"] = per_point(times.stats.traversal_steps, points.size());
    row["tests_per_point"] = per_point(times.stats.triangle_tests, points.size());
    row["checked"] = checked;
    if (embree != nullptr) {
      row["embree_mpoints_per_s"] = static_cast<double>(points.size()) / times.embree * 1e-6;
      row["embree_over_ours"] = times.embree / times.ours;
      std::size_t others = 0;
      for (std::size_t i = 0; i < points.size(); ++i)
        others += ours[i].primitive != theirs[i].primitive || ours[i].node != theirs[i].node;
      row["embree_other_face"] = others;
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace sightline::bench

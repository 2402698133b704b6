// The law of lazy building holds at small sizes, on counters: they are the same in every run.
#include <gtest/gtest.h>

#include <map>

#include "accel/published/any_builder.h"
#include "tests/bench/scenes/generators.h"
#include "tests/bench/verbs/law_windows.h"
#include "tests/bench/verbs/tree_figures.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

CommonOptions common(std::string scene = "") {
  CommonOptions options;
  options.scene = std::move(scene);
  options.threads = 2;
  options.repeat = 1;
  return options;
}

LawOptions powers(int least, int most) {
  LawOptions options;
  options.min_n = least;
  options.max_n = most;
  options.windows = 4;
  return options;
}

std::vector<Row> rows_of(const std::vector<Row>& rows, const std::string& what) {
  std::vector<Row> found;
  for (const Row& row : rows) {
    if (row["what"] == what) found.push_back(row);
  }
  return found;
}

TEST(VerbLaw, TouchesAreLinearInTheSceneAndNearlyInWhatIsSeen) {
  const auto rows = run_law(common(), powers(12, 16));
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  const auto fits = rows_of(*rows, "fit");
  ASSERT_EQ(fits.size(), 2u);
  // Slightly above today's counts, and well below the cost of one more pass over every list.
  const std::map<std::string, std::pair<double, double>> most{{"soup", {5.2, 0.8}},
                                                              {"runs", {0.7, 0.4}}};
  for (const Row& fit : fits) {
    SCOPED_TRACE(fit.dump());
    const auto [a, b] = most.at(fit["hierarchy"]);
    EXPECT_EQ(fit["points"], 5 * 11);
    EXPECT_LE(fit["a"].get<double>(), a);
    EXPECT_LE(fit["b"].get<double>(), b);
    // Small trees of runs improve in steps, as levels of runs begin to help, and end in blocks
    // soon.
    const bool runs = fit["hierarchy"] == "runs";
    EXPECT_GE(fit["r_squared"].get<double>(), runs ? 0.8 : 0.95);
    if (runs) continue;
    EXPECT_GE(fit["r_squared_log"].get<double>(), 0.93);
    EXPECT_LE(fit["max_residual"].get<double>(), 0.65);
  }
}

TEST(VerbLaw, CountsAreTheSameInEveryRunAndWithAnyNumberOfThreads) {
  CommonOptions one = common();
  one.threads = 1;
  EXPECT_EQ(*run_law(one, powers(10, 11)), *run_law(common(), powers(10, 11)));
}

TEST(VerbLaw, PointsGoFromASmallShareToEverything) {
  LawOptions options = powers(12, 12);
  options.hierarchies = {"soup"};
  const auto rows = run_law(common(), options);
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  const auto points = rows_of(*rows, "point");
  ASSERT_EQ(points.size(), 11u);
  std::uint64_t before = 0;
  for (const Row& point : points) {
    const std::uint64_t m = point["m"], touches = point["touches"], n = point["n"];
    EXPECT_GE(m, before);
    EXPECT_GE(touches, n);
    EXPECT_GE(point["rays"].get<double>(),
              kLawRaysPerTriangle * point["share"].get<double>() * 4096);
    before = m;
  }
  EXPECT_GE(before, 4096 * 0.99);
  EXPECT_EQ(points.back()["windows"], 1);
  const auto sparse = rows_of(*rows, "sparse");
  ASSERT_FALSE(sparse.empty());
  for (const Row& row : sparse) EXPECT_GT(row["over_n_log_cells"], 0);
}

TEST(VerbLaw, ComparesRunsWithTheSoupOfOneScene) {
  const auto rows = run_law(common("gen:shuffled?mesh=gen:icosphere?level=4"), powers(10, 10));
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  const auto worst = rows_of(*rows, "worst");
  ASSERT_EQ(worst.size(), 1u);
  // Faces in random order have no compact runs: runs must not increase the cost there.
  EXPECT_LE(worst.front()["over_soup"].get<double>(), 1.2) << worst.front().dump();
}

TEST(VerbLaw, RefusesOptionsThatItDoesNotMeasure) {
  CommonOptions full = common();
  full.policy = "full";
  EXPECT_EQ(run_law(full, powers(10, 10)).error().code, Code::kInvalidArgument);
  LawOptions odd = powers(10, 10);
  odd.hierarchies = {"tree"};
  EXPECT_EQ(run_law(common(), odd).error().code, Code::kInvalidArgument);
  EXPECT_EQ(run_law_nodes(common("gen:stadium"), odd).error().code, Code::kInvalidArgument);
}

TEST(VerbLawNodes, AllWorldsGiveTheSameView) {
  const auto rows = run_law_nodes(common(), powers(12, 16));
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  const auto points = rows_of(*rows, "point");
  ASSERT_EQ(points.size(), 3u);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(points[i]["triangles"], 4096 << (2 * i));
    EXPECT_EQ(points[i]["hits"], points.front()["hits"]);
    EXPECT_GT(points[i]["hits"], 1000);
    EXPECT_GT(points[i]["first_hit_us"], 0);
  }
  const auto growth = rows_of(*rows, "growth");
  ASSERT_EQ(growth.size(), 1u);
  EXPECT_EQ(growth.front()["triangles_growth"], 16);
  EXPECT_EQ(growth.front()["touches_growth"].get<double>(),
            points.back()["touches"].get<double>() / points.front()["touches"].get<double>());
}

TEST(LawWindows, LieOverTheFootprintAndHaveTheirShare) {
  const SceneSource terrain = make_terrain(5000);
  const SceneGeometry geometry(terrain);
  const AreaSampler surface(geometry);
  const double area = (geometry.hi().x - geometry.lo().x) * (geometry.hi().z - geometry.lo().z);
  for (const double share : {1.0 / 64, 0.5, 1.0}) {
    const auto windows = law_windows(geometry, surface, share, 16, 3);
    EXPECT_EQ(windows.size(), share < 1 ? 16u : 1u);
    for (const LawWindow& w : windows) {
      EXPECT_GE(w.lo_x, geometry.lo().x - 1e-9);
      EXPECT_LE(w.hi_x, geometry.hi().x + 1e-9);
      EXPECT_GE(w.lo_z, geometry.lo().z - 1e-9);
      EXPECT_LE(w.hi_z, geometry.hi().z + 1e-9);
      EXPECT_NEAR((w.hi_x - w.lo_x) * (w.hi_z - w.lo_z), share * area, 1e-9 * area);
      EXPECT_GE(static_cast<double>(w.rays()), kLawRaysPerTriangle * share * 5000);
      const accel::geometry::Ray last = w.ray(w.rays() - 1);
      EXPECT_LT(last.origin.x, w.hi_x);
      EXPECT_LT(last.origin.z, w.hi_z);
      EXPECT_GT(last.origin.y, geometry.hi().y);
    }
  }
}

TEST(SeenTriangles, AddUpOverBatches) {
  const auto scene = make_scene(common("gen:terrain?triangles=3000"));
  ASSERT_TRUE(scene.ok());
  const auto rays = make_rays(*scene, RayOptions{"overview", 400}, 1);
  ASSERT_TRUE(rays.ok());
  const auto snapshot = assemble(*scene, accel::published::default_builder());
  ASSERT_TRUE(snapshot.ok());
  SeenTriangles seen(**snapshot);
  std::vector<accel::geometry::Hit> all;
  for (std::size_t first = 0; first < rays->size(); first += 50) {
    const auto some = std::span(*rays).subspan(first, 50);
    std::vector<accel::geometry::Hit> hits(some.size());
    ASSERT_TRUE(scenegraph::trace(**snapshot, some, hits, {}).ok());
    seen.add(some, hits);
    all.insert(all.end(), hits.begin(), hits.end());
  }
  EXPECT_GT(seen.count(), 0u);
  EXPECT_EQ(seen.count(), visible_triangles(**snapshot, *rays, all));
}

}  // namespace
}  // namespace sightline::bench

// The verbs print their documented keys, agree with each other, and refuse wrong input.
#include "tests/bench/verbs/verbs.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "tests/bench/embree/peer.h"
#include "tests/bench/verbs/workload.h"
#include "tests/support/brute_force.h"

namespace sightline::bench {
namespace {

CommonOptions common(std::string scene) {
  CommonOptions options;
  options.scene = std::move(scene);
  options.threads = 2;
  options.repeat = 2;
  return options;
}

RayOptions some(const char* kind, std::size_t count) {
  RayOptions rays;
  rays.kind = kind;
  rays.count = count;
  return rays;
}

void expect_keys(const Row& row, std::initializer_list<const char*> keys) {
  for (const char* key : keys) EXPECT_TRUE(row.contains(key)) << key << " in " << row.dump();
}

const std::vector<std::string> kBuilders{"scan-one-axis", "scan-hybrid", "scan-all-axes"};

TEST(VerbBuild, PrintsItsKeysForEveryBuilder) {
  const auto rows = run_build(common("gen:icosphere?level=3"), {.builders = kBuilders});
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  ASSERT_EQ(rows->size(), 3u);
  for (const Row& row : *rows) {
    expect_keys(row, {"scene",           "builder",
                      "triangles",       "threads",
                      "build_ms",        "build_ms_min",
                      "mtris_per_s",     "nodes",
                      "leaves",          "nonempty_leaves",
                      "references",      "max_depth",
                      "cost_traverse",   "cost_intersect",
                      "sah_cost",        "expected_traversals",
                      "expected_leaves", "expected_intersections",
                      "bytes_final",     "bytes_peak",
                      "touches",         "touches_prepare"});
    EXPECT_EQ(row["triangles"], 1280);
    EXPECT_EQ(row["nodes"].get<std::uint64_t>(), 2 * row["leaves"].get<std::uint64_t>() - 1);
    EXPECT_GE(row["references"], 1280);
    EXPECT_GE(row["bytes_peak"], row["bytes_final"]);
    EXPECT_NEAR(row["sah_cost"].get<double>(),
                row["expected_traversals"].get<double>() +
                    1.5 * row["expected_intersections"].get<double>(),
                1e-9 * row["sah_cost"].get<double>());
  }
}

TEST(VerbBuild, SetsBuilderParameters) {
  CommonOptions options = common("gen:terrain?triangles=2000");
  const auto plain = run_build(options, {.builders = {"scan-hybrid"}});
  options.set = {"cost_traverse=8"};
  const auto costly = run_build(options, {.builders = {"scan-hybrid"}});
  ASSERT_TRUE(plain.ok() && costly.ok());
  EXPECT_EQ(costly->front()["cost_traverse"], 8);
  EXPECT_LT(costly->front()["nodes"], plain->front()["nodes"]);
}

TEST(VerbTrace, AllBuildersAndPoliciesGiveTheSameAnswers) {
  CommonOptions options = common("gen:city?boxes=200");
  TraceOptions trace{.builders = kBuilders, .rays = some("random", 500)};
  const auto full = run_trace(options, trace);
  ASSERT_TRUE(full.ok()) << full.error().message;
  options.policy = "first-touch";
  options.rotate = "0,0,0";
  const auto lazy = run_trace(options, trace);
  ASSERT_TRUE(lazy.ok()) << lazy.error().message;
  for (const Row& row : *full) {
    expect_keys(row,
                {"scene", "builder", "triangles", "threads", "build_ms", "trace_ms", "trace_ms_min",
                 "mrays_per_s", "hits", "hit_hash", "traversal_steps", "triangle_tests"});
    EXPECT_EQ(row["hit_hash"], lazy->front()["hit_hash"]);
    EXPECT_GT(row["hits"], 0);
  }
  trace.kind = scenegraph::QueryKind::kAny;
  const auto any = run_trace(options, trace);
  ASSERT_TRUE(any.ok()) << any.error().message;
  EXPECT_EQ(any->front()["hits"], full->front()["hits"]);
}

TEST(VerbBuild, ABuilderMayHaveItsOwnParameters) {
  CommonOptions options = common("gen:terrain?triangles=2000");
  const auto rows = run_build(
      options, {.builders = {"scan-hybrid", "scan-hybrid?cost_traverse=8&samples=4", "sah-sweep"}});
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  EXPECT_EQ((*rows)[0]["cost_traverse"], 1);
  EXPECT_EQ((*rows)[1]["cost_traverse"], 8);
  EXPECT_EQ((*rows)[1]["builder"], "scan-hybrid?cost_traverse=8&samples=4");
  EXPECT_EQ((*rows)[2]["cost_intersect"], 1.5);
  EXPECT_FALSE(run_build(options, {.builders = {"scan-hybrid?nonsense=1"}}).ok());
  EXPECT_FALSE(run_build(options, {.builders = {"scan-hybrid?samples"}}).ok());
}

TEST(VerbBuild, HasRowsForEmbreeIfItIsAvailable) {
  const auto rows =
      run_build(common("gen:icosphere?level=3"),
                {.builders = {"scan-one-axis", "embree-low", "embree-medium-robust"}});
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  ASSERT_EQ(rows->size(), embree_found() ? 3u : 1u);
  for (const Row& row : *rows) {
    expect_keys(row, {"builder", "build_ms", "mtris_per_s", "bytes_final", "bytes_peak"});
    EXPECT_GE(row["bytes_peak"], row["bytes_final"]);
  }
  const auto none = run_build(common("gen:icosphere?level=3"), {.builders = {"embree-high"}});
  EXPECT_EQ(none.ok(), embree_found());
}

TEST(VerbTrace, EmbreeRowsNameTheEntryPointAndTheDifferences) {
  if (!embree_found()) GTEST_SKIP() << "built without Embree 3";
  const auto rows = run_trace(
      common("gen:city?boxes=200"),
      {.builders = {"scan-one-axis", "embree-medium", "embree-high", "embree-medium-robust-single"},
       .rays = some("overview", 1000)});
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  EXPECT_EQ((*rows)[3]["entry"], "rtcIntersect1");
  for (std::size_t b : {1u, 2u, 3u}) {
    const Row& row = (*rows)[b];
    expect_keys(row, {"mrays_per_s", "hits", "hit_hash", "entry", "differences", "unexplained"});
    EXPECT_EQ(row["unexplained"], 0);
    EXPECT_NEAR(row["hits"].get<double>(), rows->front()["hits"].get<double>(), 10);
  }
}

TEST(VerbLazy, HasModesForEmbree) {
  const auto rows = run_lazy(common("gen:terrain?triangles=2000"),
                             {.rays = some("closeup", 300), .modes = {"lazy", "embree-low"}});
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  ASSERT_EQ(rows->size(), embree_found() ? 2u : 1u);
  for (const Row& row : *rows) {
    expect_keys(row, {"mode", "seconds_to_hits", "build_ms", "trace_ms", "triangles_total",
                      "triangles_touched", "visible_fraction", "bytes_final", "hit_hash"});
  }
  EXPECT_EQ(rows->back()["triangles_touched"] == 2000, embree_found());
}

TEST(VerbLazy, PrintsRatiosAndEmbreesOwnLaziness) {
  const auto rows = run_lazy(
      common("gen:city?boxes=1000"),
      {.rays = some("closeup", 300), .modes = {"lazy", "full", "embree-low", "embree-lazy"}});
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  ASSERT_EQ(rows->size(), embree_found() ? 4u : 2u);
  EXPECT_GT(rows->front()["over_full"], 0);
  EXPECT_FALSE((*rows)[1].contains("over_lazy"));
  if (!embree_found()) return;
  expect_keys(rows->front(), {"over_embree_low", "over_embree_lazy"});
  const Row& row = rows->back();
  EXPECT_EQ(row["mode"], "embree-lazy");
  EXPECT_EQ(row["unexplained"], 0);
  EXPECT_GT(row["triangles_touched"], 0);
  EXPECT_LT(row["triangles_touched"], row["triangles_total"]);
  EXPECT_LT(row["objects_built"], 20);
}

TEST(VerbLazy, AllHierarchiesGiveTheSameAnswers) {
  LazyOptions options{.rays = some("closeup", 300), .modes = {"lazy"}};
  const auto runs = run_lazy(common("gen:terrain?triangles=20000"), options);
  options.hierarchy = "soup";
  const auto soup = run_lazy(common("gen:terrain?triangles=20000"), options);
  ASSERT_TRUE(runs.ok() && soup.ok());
  EXPECT_EQ(runs->front()["hit_hash"], soup->front()["hit_hash"]);
  EXPECT_LE(runs->front()["touches"], soup->front()["touches"]);
  options.hierarchy = "pile";
  EXPECT_EQ(run_lazy(common("gen:stadium"), options).error().code, Code::kInvalidArgument);
}

TEST(VerbKernel, ChecksPassesAgainstCounting) {
  const auto rows = run_kernel(common(""), {.boxes = {1, 1000}});
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  EXPECT_EQ(rows->size(), 10u);
  for (const Row& row : *rows) EXPECT_GT(row["mboxes_per_s"], 0);
}

TEST(VerbLazy, ModesAgreeAndLazyTouchesLess) {
  const auto rows = run_lazy(common("gen:terrain?triangles=20000"), {.rays = some("closeup", 300)});
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  ASSERT_EQ(rows->size(), 2u);
  const Row &lazy = (*rows)[0], &full = (*rows)[1];
  for (const Row& row : *rows) {
    expect_keys(
        row, {"mode", "seconds_to_hits", "seconds_to_hits_min", "build_ms", "trace_ms", "touches",
              "touches_prepare", "cells_expanded", "triangles_total", "triangles_touched",
              "visible_fraction", "bytes_final", "hit_hash", "triangle_tests"});
  }
  EXPECT_EQ(lazy["mode"], "lazy");
  EXPECT_EQ(full["mode"], "full");
  EXPECT_EQ(lazy["hit_hash"], full["hit_hash"]);
  EXPECT_LT(lazy["triangles_touched"], full["triangles_touched"]);
  EXPECT_EQ(full["triangles_touched"], 20000);
  EXPECT_LT(lazy["touches"], full["touches"]);
  EXPECT_LE(full["visible_fraction"], 0.05);
  EXPECT_GT(full["visible_fraction"], 0);
}

TEST(VerbLazy, BatchesDoNotChangeAnswers) {
  LazyOptions options{.rays = some("overview", 300)};
  const auto whole = run_lazy(common("gen:stadium"), options);
  options.batch = 7;
  const auto cut = run_lazy(common("gen:stadium"), options);
  ASSERT_TRUE(whole.ok() && cut.ok());
  EXPECT_EQ(whole->front()["hit_hash"], cut->front()["hit_hash"]);
}

TEST(VerbCurve, SamplesLieOnBothCurves) {
  CommonOptions options = common("gen:wall?triangles=2000");
  const auto rows = run_curve(options, {.axis = 'x', .points = 50});
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  std::map<std::string, int> counts;
  double least_true = 1e300, least_sample = 1e300;
  for (const Row& row : *rows) {
    const std::string what = row["what"];
    ++counts[what];
    EXPECT_GE(row["left"].get<double>() + row["right"].get<double>(), 2000 - 1e-9) << row.dump();
    double& least = what == "true" ? least_true : least_sample;
    if (what != "suggested") least = std::min(least, row["cost"].get<double>());
  }
  EXPECT_EQ(counts["uniform"], 8);
  EXPECT_EQ(counts["adaptive"], 8);
  EXPECT_GE(counts["true"], 53);  // Both sides of the wall
  EXPECT_EQ(counts["true"], counts["suggested"]);
  EXPECT_LE(least_true, least_sample);
}

TEST(VerbRays, WritesTheFile) {
  const auto file = std::filesystem::path(testing::TempDir()) / "sightline_verb_rays_test.npy";
  const auto rows =
      run_rays(common("gen:grid?triangles=50"), {.rays = some("aimed", 10), .out = file.string()});
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  EXPECT_EQ(std::filesystem::file_size(file), 128u + 640u);
  std::filesystem::remove(file);
}

TEST(VerbCheck, ComparesAFamilyInEveryState) {
  const auto rows = run_check(common(""), {.family = "fan", .points = 60});
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  ASSERT_EQ(rows->size(), 2u);
  for (const Row& row : *rows) {
    EXPECT_EQ(row["points"], 60);
    EXPECT_EQ(row["mismatches"], 0);
    EXPECT_GT(row["nearest_faces"], 60) << "many have one corner";
    EXPECT_EQ(row["checked"], 12 * 60);
  }
  EXPECT_FALSE(run_check(common(""), {.family = "nothing"}).ok());
}

TEST(VerbLazyPoints, CountsWhatPointsBuild) {
  const auto rows = run_lazy_points(common("gen:terrain?triangles=20000"),
                                    {.counts = {1, 50}, .spot = 100, .cold = 3});
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  ASSERT_EQ(rows->size(), 6u);
  for (std::size_t i = 0; i < 2; ++i) {
    expect_keys((*rows)[i], {"what", "count", "touches_per_triangle", "rays_touches_per_triangle",
                             "over_rays", "cells_expanded", "share_built"});
    EXPECT_GT((*rows)[i]["touches_per_triangle"], 0);
  }
  EXPECT_LT((*rows)[2]["share_built"], 0.1) << "around one spot";
  expect_keys((*rows)[3], {"point_ns_per_triangle", "ray_ns_per_triangle", "over_rays"});
}

TEST(VerbCompetitive, HasPoints) {
  const auto rows = run_competitive(common("gen:terrain?triangles=5000"),
                                    {.points = true, .measured = 100, .most = 100});
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  ASSERT_EQ(rows->size(), 3u * 3 * 5 + 1);
  EXPECT_GT(rows->back()["competitive_ratio"], 0);
}

TEST(Verbs, RefuseUnknownValues) {
  const auto code = [](const auto& result) {
    EXPECT_FALSE(result.ok());
    return result.ok() ? Code::kInternal : result.error().code;
  };
  const std::string scene = "gen:grid?triangles=50";
  const RayOptions random = some("random", 10);
  EXPECT_EQ(code(run_build(common(scene), {.builders = {"magic"}})), Code::kInvalidArgument);
  EXPECT_EQ(code(run_lazy(common(scene), {.rays = random, .modes = {"eager"}})),
            Code::kInvalidArgument);
  EXPECT_EQ(code(run_trace(common(scene), {.builders = kBuilders, .rays = some("odd", 1)})),
            Code::kInvalidArgument);
  CommonOptions options = common(scene);
  options.policy = "psychic";
  EXPECT_EQ(code(run_build(options, {.builders = kBuilders})), Code::kInvalidArgument);
  options = common(scene);
  options.rotate = "1,2";
  EXPECT_EQ(code(run_build(options, {.builders = kBuilders})), Code::kInvalidArgument);
  options = common(scene);
  options.set = {"samples"};
  EXPECT_EQ(code(run_build(options, {.builders = kBuilders})), Code::kInvalidArgument);
  EXPECT_EQ(code(run_build(common("/nonexistent.ply"), {.builders = kBuilders})), Code::kNotFound);
}

TEST(AnswerCheck, RejectsAWrongAnswer) {
  const auto scene = make_scene(common("gen:icosphere?level=2"));
  ASSERT_TRUE(scene.ok());
  const auto rays = make_rays(*scene, some("overview", 100), 1);
  ASSERT_TRUE(rays.ok());
  const auto check = AnswerCheck::make(*scene, *rays, scenegraph::QueryKind::kClosest);
  ASSERT_TRUE(check.ok());
  const auto snapshot = assemble(*scene, {});
  std::vector<accel::geometry::Hit> hits(rays->size());
  ASSERT_TRUE(scenegraph::trace(**snapshot, *rays, hits, {}).ok());
  EXPECT_TRUE((*check)(hits).ok());
  hits[hits.size() / 2] = accel::geometry::Hit{};
  const auto wrong = (*check)(hits);
  ASSERT_FALSE(wrong.ok());
  EXPECT_EQ(wrong.error().code, Code::kDataLoss);
}

}  // namespace
}  // namespace sightline::bench

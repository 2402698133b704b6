// Builders and parameters by name, and the trees that they make.
#include "accel/published/any_builder.h"

#include <gtest/gtest.h>

#include "accel/kdtree/epoch.h"
#include "accel/mesh/mesh_tree.h"
#include "tests/support/mesh_query.h"
#include "tests/support/scenes.h"

namespace sightline::accel::published {
namespace {

TEST(AnyBuilder, HasEveryBuilderOfThePapers) {
  for (const std::string_view name :
       {"spatial-median", "object-median", "sah-naive", "sah-sort", "sah-sweep", "min-max-bins",
        "scan-one-axis", "scan-hybrid", "scan-all-axes", "bvh-sweep", "bvh-binned", "bvh-esc",
        "bvh-evh", "sbvh"}) {
    EXPECT_TRUE(make_builder(name)) << name;
  }
  for (const std::string_view name : builder_names()) {
    const auto builder = make_builder(name);
    ASSERT_TRUE(builder) << name;
    if (const auto* bvh = std::get_if<bvh::BvhBuilder>(&*builder)) {
      EXPECT_FALSE(bvh->check()) << name;
      continue;
    }
    EXPECT_FALSE(std::visit([](const auto& b) { return b.check(); }, std::get<KdBuilder>(*builder)))
        << name;
  }
}

TEST(SetParameter, TakesNumbersCountsAndSwitches) {
  AnyBuilder builder = *make_builder("sah-sort");
  const auto exact = [&] { return std::get<kd::ExactBuilder>(std::get<KdBuilder>(builder)); };
  EXPECT_EQ(exact().search, kd::ExactSearch::kSort);
  EXPECT_TRUE(set_parameter(builder, "lambda", "1"));
  EXPECT_EQ(exact().costs.lambda, 1);
  EXPECT_TRUE(set_parameter(builder, "bad_refines", "3"));
  EXPECT_EQ(exact().bad_refines, 3u);
  for (const auto& [text, on] :
       {std::pair("off", false), {"on", true}, {"0", false}, {"1", true}}) {
    EXPECT_TRUE(set_parameter(builder, "clip", text));
    EXPECT_EQ(exact().clip, on);
    EXPECT_EQ(exact().clips(), on);
  }
}

TEST(SetParameter, RefusesWrongValuesWithAReason) {
  AnyBuilder builder = *make_builder("sah-sweep");
  const AnyBuilder before = builder;
  const auto message = [&](std::string_view key, std::string_view value) {
    const Status status = set_parameter(builder, key, value);
    return status ? std::string() : status.error().message;
  };
  EXPECT_EQ(message("lambda", "1.5"), "lambda is 1.500000, must lie in 0.000001 to 1.000000");
  EXPECT_EQ(message("lambda", "nan"), "lambda: \"nan\" is not a number");
  EXPECT_EQ(message("lambda", ""), "lambda: \"\" is not a number");
  EXPECT_EQ(message("bad_refines", "1.5"),
            "bad_refines: \"1.5\" is not a whole number of 0 to 4294967295");
  EXPECT_EQ(message("bad_refines", "-1"),
            "bad_refines: \"-1\" is not a whole number of 0 to 4294967295");
  EXPECT_EQ(message("bad_refines", "99"), "bad_refines is 99, must lie in 0 to 16");
  EXPECT_EQ(message("clip", "2"), "clip: \"2\" is not on, off, 1 or 0");
  EXPECT_EQ(
      message("samples", "8"),
      "no parameter \"samples\"; there are: cost_traverse cost_intersect lambda bad_refines clip");
  EXPECT_EQ(builder, before);
}

TEST(SetParameter, OfAHierarchyListsTheParametersOfItsMethod) {
  AnyBuilder binned = *make_builder("bvh-binned");
  const Status status = set_parameter(binned, "alpha", "0");
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().message,
            "no parameter \"alpha\"; there are: leaf_size split_small cost_traverse cost_intersect "
            "bins");
  EXPECT_FALSE(set_parameter(binned, "bins", "257"));
  EXPECT_FALSE(set_parameter(binned, "leaf_size", "0"));
  AnyBuilder spatial = *make_builder("sbvh");
  EXPECT_FALSE(set_parameter(spatial, "alpha", "1.5"));
  EXPECT_FALSE(set_parameter(spatial, "budget", "-1"));
}

TEST(SetParameter, OneNameMaySetSeveral) {
  AnyBuilder builder = *make_builder("scan-hybrid");
  EXPECT_TRUE(set_parameter(builder, "samples", "4"));
  const auto& scan = std::get<kd::HuntScan>(std::get<KdBuilder>(builder));
  EXPECT_EQ(scan.uniform_samples, 4u);
  EXPECT_EQ(scan.adaptive_samples, 4u);
}

TEST(SetParameter, ReachesEveryBuilder) {
  for (const auto& [name, key, value] : {std::tuple("spatial-median", "leaf_size", "4"),
                                         {"object-median", "max_depth", "12"},
                                         {"min-max-bins", "bins", "64"},
                                         {"min-max-bins", "subsample", "off"},
                                         {"min-max-bins", "threads", "2"},
                                         {"scan-all-axes", "empty_bonus", "1"},
                                         {"scan-fast", "clip_crowds", "0"},
                                         {"scan-best", "budget", "7.5"},
                                         {"bvh-sweep", "leaf_size", "4"},
                                         {"bvh-sweep", "split_small", "on"},
                                         {"bvh-binned", "bins", "16"},
                                         {"bvh-esc", "threshold", "0.01"},
                                         {"bvh-evh", "budget", "2"},
                                         {"bvh-esc", "repeats", "on"},
                                         {"sbvh", "alpha", "0"},
                                         {"sbvh", "node_overlap", "0.2"},
                                         {"sbvh", "spatial_bins", "64"},
                                         {"sbvh", "unsplit", "off"},
                                         {"sbvh", "budget", "1"}}) {
    AnyBuilder builder = *make_builder(name);
    const AnyBuilder before = builder;
    EXPECT_TRUE(set_parameter(builder, key, value)) << name << key;
    EXPECT_NE(builder, before) << name << key;
  }
}

TEST(WholeTrees, AreAllButTheProducts) {
  for (const std::string_view name : builder_names()) {
    AnyBuilder builder = *make_builder(name);
    const bool ours = name == "scan-fast" || name == "scan-best";
    EXPECT_EQ(mesh::TreeBuilder(builder).whole == nullptr, ours) << name;
    if (!ours) continue;
    EXPECT_TRUE(set_parameter(builder, "blocks", "off"));
    EXPECT_NE(mesh::TreeBuilder(builder).whole, nullptr) << name;
  }
}

TEST(WholeTrees, OnlyRaysThatMayBuildBuild) {
  const tests::TestMesh mesh = tests::icosphere(3);
  for (const std::string_view name : builder_names()) {
    const AnyBuilder builder = *make_builder(name);
    if (mesh::TreeBuilder(builder).whole == nullptr) continue;
    mesh::MeshTree tree(mesh.view(), mesh::compute_mesh_stats(mesh.view()), builder);
    const auto ask = [&](lazy::Growth growth) {
      const kdtree::EpochPin pin;
      tests::MeshQuery query;
      query.ray = *geometry::make_local_ray({0.1, 0.2, 3}, {0, 0, -1});
      query.cells.growth = growth;
      kdtree::WalkCounters walked;
      kdtree::BuildCounters built;
      tests::ask(tree, query, walked, built);
      return query;
    };
    EXPECT_EQ(tree.metrics().deferred_cells, 1u);
    EXPECT_EQ(tree.growth().cells_deferred, 1u);
    const tests::MeshQuery skipped = ask(lazy::Growth::kBuiltOnly),
                           searched = ask(lazy::Growth::kNone);
    EXPECT_TRUE(!skipped.found && skipped.saw_deferred);
    EXPECT_TRUE(searched.found && searched.saw_deferred);
    EXPECT_TRUE(tree.untouched());
    const tests::MeshQuery built = ask(lazy::Growth::kFirstTouch);
    EXPECT_TRUE(built.found && !built.saw_deferred);
    EXPECT_EQ(built.best_t, searched.best_t);
    EXPECT_EQ(built.best_primitive, searched.best_primitive);
    EXPECT_EQ(tree.growth().references_built, mesh.faces.size());
    EXPECT_GT(tree.bytes(), 0u);
  }
}

}  // namespace
}  // namespace sightline::accel::published

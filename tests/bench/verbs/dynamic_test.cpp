// Moving scenes: frames of directories and swarms, the keys that the verbs print, and right
// answers.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/bench/embree/peer.h"
#include "tests/bench/scenes/generate_swarm.h"
#include "tests/bench/scenes/generators.h"
#include "tests/bench/scenes/motion.h"
#include "tests/bench/scenes/scene_geometry.h"
#include "tests/bench/scenes/staged_scene.h"
#include "tests/bench/verbs/verbs.h"

namespace sightline::bench {
namespace {

using accel::geometry::Vec3d;

// A directory of pyramids whose top moves.
class Frames : public testing::Test {
 protected:
  Frames() {
    directory_ = std::filesystem::path(testing::TempDir()) /
                 ("sightline_frames_" +
                  std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::remove_all(directory_);
    std::filesystem::create_directory(directory_);
    for (int frame = 0; frame < 3; ++frame) write(frame);
  }
  ~Frames() override { std::filesystem::remove_all(directory_); }

  void write(int frame) const {
    std::ofstream file(directory_ / ("frame_" + std::to_string(frame) + ".ply"));
    file << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
            "property float z\nelement face 3\nproperty list uchar int vertex_indices\n"
            "end_header\n0 0 0\n1 0 0\n0 0 1\n"
         << 0.2 + 0.1 * frame << " 1 0.2\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
  }
  std::string directory() const { return directory_.string(); }

  std::filesystem::path directory_;
};

TEST_F(Frames, OfADirectoryAreCopiedSideBySide) {
  const auto motion = Motion::make(directory(), 4);
  ASSERT_TRUE(motion.ok()) << motion.error().message;
  EXPECT_EQ(motion->frames(), 3u);
  EXPECT_EQ(motion->nodes(), 4u);
  EXPECT_EQ(motion->triangles(), 12u);
  EXPECT_FALSE(motion->rigid());
  const auto updates = motion->updates(1, 10);
  ASSERT_EQ(updates.size(), 4u);
  const auto& patch = std::get<scenegraph::model::PatchVertices>(updates[2]);
  EXPECT_EQ(patch.nodes, std::vector<scenegraph::model::NodeRef>{12});
  EXPECT_EQ(patch.positions, motion->vertices(2, 1));
  EXPECT_NE(motion->vertices(0, 0), motion->vertices(0, 1));
  EXPECT_EQ(motion->vertices(0, 0), motion->vertices(0, 3));
  EXPECT_NE(motion->transform(0, 0), motion->transform(1, 0));
  EXPECT_EQ(motion->transform(3, 0), motion->transform(3, 2));
}

TEST_F(Frames, OfAnotherTopologyAreRefused) {
  std::ofstream(directory_ / "frame_9.ply")
      << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
         "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
         "end_header\n0 0 0\n1 0 0\n0 0 1\n3 0 1 2\n";
  EXPECT_EQ(Motion::make(directory(), 1).error().code, Code::kInvalidArgument);
  EXPECT_EQ(Motion::make(directory() + "/none", 1).error().code, Code::kNotFound);
  EXPECT_EQ(Motion::make("gen:swarm?triangles=80", 2).error().code, Code::kInvalidArgument);
  EXPECT_EQ(Motion::make("gen:city?boxes=60", 1).error().code, Code::kInvalidArgument);
}

TEST(Swarm, HasItsTrianglesAndIsPeriodic) {
  const SceneSource swarm = make_swarm(1000);
  EXPECT_EQ(swarm.unique_triangles(), 1000u);
  EXPECT_EQ(swarm.nodes.size(), 13u);
  EXPECT_EQ(swarm_transforms(13, 5), swarm_transforms(13, 5 + kSwarmFrames));
  const auto before = swarm_transforms(13, 63), after = swarm_transforms(13, 0);
  for (std::size_t n = 0; n < 13; ++n) {
    const Vec3d step = after[n].point({}) - before[n].point({});
    EXPECT_GT(length(step), 0);
    EXPECT_LT(length(step), 20);
    EXPECT_TRUE(inverse(after[n]));
  }
}

TEST(StagedScene, TheStaticPartIsTenTimesAsLargeAndBelow) {
  const auto motion = Motion::make("gen:swarm?triangles=2000", 1);
  ASSERT_TRUE(motion.ok());
  const auto staged = StagedScene::make(make_terrain(2000), *motion);
  ASSERT_TRUE(staged.ok());
  const SceneSource static_part = staged->only_static();
  const SceneGeometry geometry(static_part);
  const scenegraph::model::DoubleBox& frames = motion->bounds();
  const double diagonal = length(frames.hi - frames.lo);
  EXPECT_NEAR(geometry.diagonal(), 10 * diagonal, 1e-4 * diagonal);
  EXPECT_NEAR(geometry.hi().y, frames.lo.y, 1e-4 * diagonal);
  EXPECT_NEAR(geometry.center().x, (frames.lo.x + frames.hi.x) / 2, 1e-4 * diagonal);
  EXPECT_NEAR(geometry.center().z, (frames.lo.z + frames.hi.z) / 2, 1e-4 * diagonal);
  EXPECT_EQ(staged->source.nodes.size(), staged->static_nodes + motion->nodes());
  EXPECT_EQ(staged->at(*motion, 7).nodes.back().parent_from_local,
            motion->transform(motion->nodes() - 1, 7));
}

CommonOptions common() {
  CommonOptions options;
  options.threads = 2;
  options.repeat = 2;
  return options;
}

DynamicOptions some_frames(std::string frames) {
  DynamicOptions options;
  options.frames = std::move(frames);
  options.static_scene = "gen:terrain?triangles=2000";
  options.rays = {"overview", 900};
  options.length = 5;
  return options;
}

void expect_keys(const Row& row, std::initializer_list<const char*> keys) {
  for (const char* key : keys) EXPECT_TRUE(row.contains(key)) << key << " in " << row.dump();
}

TEST(VerbDynamic, PrintsARowForEachFrameAndASummary) {
  DynamicOptions options = some_frames("gen:swarm?triangles=4000");
  options.small_static_scene = "gen:terrain?triangles=200";
  options.view = "frames";
  const auto rows = run_dynamic(common(), options);
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  ASSERT_EQ(rows->size(), 6u);
  for (std::size_t f = 0; f < 5; ++f) {
    expect_keys((*rows)[f],
                {"frame", "update_ms", "build_ms", "trace_ms", "static_trace_ms", "static_touches",
                 "dynamic_touches", "small_update_ms", "small_build_ms", "small_trace_ms"});
    if (f >= 2) {
      EXPECT_EQ((*rows)[f]["static_touches"], 0) << "frame " << f;
    }
    EXPECT_GT((*rows)[f]["dynamic_touches"], 0);
  }
  expect_keys(rows->back(),
              {"fps", "trace_over_static", "update_build_over_small", "triangles_moving"});
  EXPECT_EQ(rows->back()["triangles_static"], 2000);
}

TEST_F(Frames, ThatDeformGiveTheSameAnswersAsEmbree) {
  DynamicOptions options = some_frames(directory());
  options.copies = 9;
  options.shadow = true;
  options.view = "frames";
  options.peers = {"embree-low", "embree-refit"};
  const auto rows = run_dynamic(common(), options);
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  EXPECT_GT(rows->front()["hits"], 0);
  if (!embree_found()) return;
  for (const char* peer : {"embree_low", "embree_refit"}) {
    EXPECT_EQ(rows->back()[std::string(peer) + "_unexplained"], 0);
    EXPECT_GT(rows->back()[std::string(peer) + "_fps"], 0);
  }
}

TEST(VerbDynamic, RigidFramesGiveTheSameAnswersAsEmbree) {
  if (!embree_found()) GTEST_SKIP() << "built without Embree 3";
  DynamicOptions options = some_frames("gen:swarm?triangles=4000");
  options.view = "frames";
  options.peers = {"embree-low", "embree-refit"};
  const auto rows = run_dynamic(common(), options);
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  EXPECT_EQ(rows->back()["embree_low_unexplained"], 0);
  EXPECT_EQ(rows->back()["embree_refit_unexplained"], 0);
}

TEST(VerbDynamic, RefusesUnknownValues) {
  const auto code = [](const DynamicOptions& options) {
    const auto rows = run_dynamic(common(), options);
    EXPECT_FALSE(rows.ok());
    return rows.ok() ? Code::kInternal : rows.error().code;
  };
  DynamicOptions options = some_frames("gen:swarm?triangles=80");
  options.view = "sideways";
  EXPECT_EQ(code(options), Code::kInvalidArgument);
  options = some_frames("gen:swarm?triangles=80");
  options.peers = {"embree-wish"};
  EXPECT_EQ(code(options), Code::kInvalidArgument);
  options = some_frames("/nonexistent");
  EXPECT_EQ(code(options), Code::kNotFound);
}

TEST(VerbTwoTrees, ComparesTwoTreesWithOne) {
  CommonOptions options = common();
  options.scene = "gen:terrain?triangles=2000";
  const auto rows = run_two_trees(options, {.rays = {"random", 500}, .parts = 20});
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  ASSERT_EQ(rows->size(), 5u);
  for (std::size_t i : {1u, 2u, 4u}) {
    expect_keys((*rows)[i], {"variant", "trace_ms", "hit_hash", "over", "ratio", "ratio_q1"});
    EXPECT_GT((*rows)[i]["ratio"], 0);
  }
  EXPECT_EQ((*rows)[3]["hit_hash"], (*rows)[4]["hit_hash"]);
  EXPECT_NE((*rows)[0]["hit_hash"], (*rows)[4]["hit_hash"]);
}

TEST(VerbUpdates, HasARowForEachKindAndSize) {
  CommonOptions options = common();
  options.repeat = 2;
  const auto rows = run_updates(options, {.nodes = {1'000}, .items = 10});
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  ASSERT_EQ(rows->size(), 28u);  // 6 kinds in batches of both sizes, 2 in one, 2 layouts
  for (const Row& row : *rows) {
    expect_keys(row,
                {"nodes", "layout", "kind", "items", "updates", "us", "us_min", "us_per_item"});
  }
}

}  // namespace
}  // namespace sightline::bench

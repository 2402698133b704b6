// Embree as a peer answers as we do, under our node ids, and restores floating-point modes.
#include "tests/bench/embree/peer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <xmmintrin.h>

#include "scenegraph/trace.h"
#include "tests/bench/scenes/generators.h"
#include "tests/bench/scenes/load_scene.h"
#include "tests/bench/scenes/ray_kinds.h"
#include "tests/bench/verbs/disagreement.h"
#include "tests/support/random.h"

namespace sightline::bench {
namespace {

class EmbreePeerTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!embree_found()) GTEST_SKIP() << "built without Embree 3";
  }
};

// Three instances of a sphere, one of them mirrored and scaled, and a separate sphere.
SceneSource family() {
  SceneSource scene = *load_scene("gen:icosphere?level=3");
  const SourceMesh sphere = scene.meshes.front();
  SceneSource family;
  const std::size_t shared = family.add_mesh(sphere), own = family.add_mesh(sphere);
  const std::size_t root = family.add_node({}, "root", rotation(20, 30, 40));
  family.add_node(root, "a", translation(3, 0, 0), shared);
  family.add_node(root, "b", {{-2, 0, 0, -3, 0, 1, 0, 1, 0, 0, 0.5, 0}}, shared);
  family.add_node(root, "c", {}, shared);
  family.add_node(root, "d", translation(0, 3, 0), own);
  return family;
}

struct Answers {
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot;
  std::vector<accel::geometry::Ray> rays;
  std::vector<accel::geometry::Hit> hits;
};

Answers answers(const SceneSource& scene, RayKind kind, bool any) {
  Answers ours;
  ours.snapshot = *assemble(scene, {});
  ours.rays = *make_rays(scene, kind, 2000, 7);
  ours.hits.resize(ours.rays.size());
  const auto query = any ? scenegraph::QueryKind::kAny : scenegraph::QueryKind::kClosest;
  EXPECT_TRUE(scenegraph::trace(*ours.snapshot, ours.rays, ours.hits, {.kind = query}).ok());
  return ours;
}

TEST(NodeId, IsTheIndexInTheSourcePlusOne) {
  const SceneSource scene = family();
  const auto snapshot = assemble(scene, {});
  ASSERT_TRUE(snapshot.ok());
  for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
    ASSERT_NE((*snapshot)->find(node_id(n)), nullptr);
    EXPECT_EQ((*snapshot)->find(node_id(n))->name, scene.nodes[n].name);
  }
}

TEST_F(EmbreePeerTest, FindsTheNearestFacesOfInstances) {
  const SceneSource scene = family();
  const auto snapshot = *assemble(scene, {});
  tests::Random random(3);
  std::vector<accel::geometry::Vec3d> points;
  std::vector<accel::geometry::Ray> rays;
  for (int i = 0; i < 500; ++i) {
    points.push_back({random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-5, 5)});
    rays.push_back({.origin = points.back(), .direction = {1, 0, 0}});
  }
  std::vector<accel::geometry::Hit> ours(points.size()), theirs(points.size());
  ASSERT_TRUE(scenegraph::trace(*snapshot, rays, ours, {.points = true}).ok());
  auto peer = *EmbreePeer::make(scene, {}, 2);
  ASSERT_TRUE(peer->build().ok());
  EXPECT_GT(peer->nearest(points, theirs), 0);
  int other_nodes = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(theirs[i].t, ours[i].t, 1e-5) << i;
    other_nodes += theirs[i].node != ours[i].node ? 1 : 0;
  }
  EXPECT_LE(other_nodes, 5) << "where two nodes are as near";
}

TEST_F(EmbreePeerTest, AgreesWithOurAnswersForEveryQualityAndKind) {
  const SceneSource scene = family();
  for (const RayKind kind : {RayKind::kOverview, RayKind::kRandom}) {
    for (const bool any : {false, true}) {
      const Answers ours = answers(scene, kind, any);
      for (const std::string_view name : embree_names()) {
        auto peer = EmbreePeer::make(scene, *parse_embree(name), 2);
        ASSERT_TRUE(peer.ok()) << peer.error().message;
        const auto built = (*peer)->build();
        ASSERT_TRUE(built.ok()) << built.error().message;
        EXPECT_GT(built->bytes_final, 0u);
        EXPECT_GE(built->bytes_peak, built->bytes_final);
        (*peer)->choose_entry(ours.rays, any);
        EXPECT_TRUE((*peer)->entry().starts_with(any ? "rtcOccluded" : "rtcIntersect"));
        std::vector<accel::geometry::Hit> theirs(ours.rays.size());
        EXPECT_GT((*peer)->trace(ours.rays, any, theirs, 0), 0);
        const Disagreement d = explain(ours.snapshot, ours.rays, ours.hits, theirs, any);
        EXPECT_EQ(d.unexplained, 0u) << name;
        EXPECT_LT(d.differences, 20u) << name;
      }
    }
  }
}

TEST_F(EmbreePeerTest, SingleRaysTryNoOtherEntryPoint) {
  const SceneSource scene = family();
  const auto settings = parse_embree("embree-medium-robust-single");
  ASSERT_TRUE(settings && settings->single && settings->robust);
  auto peer = EmbreePeer::make(scene, *settings, 2);
  ASSERT_TRUE(peer.ok());
  ASSERT_TRUE((*peer)->build().ok());
  // Coherent rays, for which packets are faster.
  const Answers ours = answers(scene, RayKind::kOverview, false);
  (*peer)->choose_entry(ours.rays, false);
  EXPECT_EQ((*peer)->entry(), "rtcIntersect1");
  (*peer)->choose_entry(ours.rays, true);
  EXPECT_EQ((*peer)->entry(), "rtcOccluded1");
}

TEST_F(EmbreePeerTest, BatchesAndRebuildingChangeNoAnswer) {
  const SceneSource scene = family();
  const Answers ours = answers(scene, RayKind::kRandom, false);
  auto peer = EmbreePeer::make(scene, {}, 2);
  ASSERT_TRUE(peer.ok());
  ASSERT_TRUE((*peer)->build().ok());
  (*peer)->choose_entry(ours.rays, false);
  std::vector<accel::geometry::Hit> whole(ours.rays.size()), cut(ours.rays.size());
  (*peer)->trace(ours.rays, false, whole, 0);
  ASSERT_TRUE((*peer)->build().ok());
  (*peer)->trace(ours.rays, false, cut, 37);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_EQ(whole[i].state, cut[i].state);
    EXPECT_EQ(whole[i].node, cut[i].node);
    EXPECT_EQ(whole[i].primitive, cut[i].primitive);
  }
}

TEST_F(EmbreePeerTest, LazyObjectsGrowAndGiveTheSameAnswers) {
  const SceneSource scene = family();
  for (const RayKind kind : {RayKind::kCloseup, RayKind::kRandom}) {
    for (const bool any : {false, true}) {
      const Answers ours = answers(scene, kind, any);
      auto peer = EmbreePeer::make_lazy(scene, 2);
      ASSERT_TRUE(peer.ok()) << peer.error().message;
      (*peer)->choose_entry(ours.rays, any);
      ASSERT_TRUE((*peer)->build().ok());
      EXPECT_EQ((*peer)->grown().objects, 0u);
      EXPECT_EQ((*peer)->grown().triangles, 0u);
      const std::uint64_t bytes = (*peer)->grown().bytes;
      std::vector<accel::geometry::Hit> theirs(ours.rays.size());
      (*peer)->trace(ours.rays, any, theirs, 100);
      const EmbreeGrown grown = (*peer)->grown();
      EXPECT_GE(grown.objects, 1u);
      EXPECT_LE(grown.objects, 2u);  // Meshes: three nodes share one
      EXPECT_EQ(grown.triangles, grown.objects * 1280);
      EXPECT_GT(grown.bytes, bytes);
      EXPECT_GT(grown.seconds_in_trace, 0);
      const Disagreement d = explain(ours.snapshot, ours.rays, ours.hits, theirs, any);
      EXPECT_EQ(d.unexplained, 0u);
      EXPECT_LT(d.differences, 20u);
    }
  }
}

TEST_F(EmbreePeerTest, LazyObjectsAreBuiltOnceByManyThreads) {
  const SceneSource scene = make_village(64);
  const Answers ours = answers(scene, RayKind::kOverview, false);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 8);
  auto peer = EmbreePeer::make_lazy(scene, 8);
  ASSERT_TRUE(peer.ok());
  tbb::task_arena arena(8);
  for (int repeat = 0; repeat < 5; ++repeat) {
    std::vector<accel::geometry::Hit> theirs(ours.rays.size());
    arena.execute([&] {
      ASSERT_TRUE((*peer)->build().ok());
      (*peer)->trace(ours.rays, false, theirs, 0);
    });
    EXPECT_EQ(explain(ours.snapshot, ours.rays, ours.hits, theirs, false).unexplained, 0u);
  }
}

TEST_F(EmbreePeerTest, SkipsFacesThatAreNoTriangles) {
  SceneSource scene = *load_scene("gen:icosphere?level=2");
  scene.meshes.front().faces.push_back(
      {accel::geometry::kNoVertex, accel::geometry::kNoVertex, accel::geometry::kNoVertex});
  const Answers ours = answers(scene, RayKind::kRandom, false);
  auto peer = EmbreePeer::make(scene, {}, 1);
  ASSERT_TRUE(peer.ok());
  ASSERT_TRUE((*peer)->build().ok());
  std::vector<accel::geometry::Hit> theirs(ours.rays.size());
  (*peer)->trace(ours.rays, false, theirs, 0);
  EXPECT_EQ(explain(ours.snapshot, ours.rays, ours.hits, theirs, false).unexplained, 0u);
}

TEST_F(EmbreePeerTest, RestoresTheDenormalMode) {
  const unsigned before = _mm_getcsr();
  const SceneSource scene = family();
  const Answers ours = answers(scene, RayKind::kRandom, false);
  auto peer = EmbreePeer::make(scene, {}, 2);
  ASSERT_TRUE(peer.ok());
  ASSERT_TRUE((*peer)->build().ok());
  std::vector<accel::geometry::Hit> theirs(ours.rays.size());
  (*peer)->trace(ours.rays, false, theirs, 0);
  constexpr unsigned kExceptionFlags = 0x3f;
  EXPECT_EQ(_mm_getcsr() & ~kExceptionFlags, before & ~kExceptionFlags);
}

TEST_F(EmbreePeerTest, CountsEveryTriangleOnce) {
  const SceneSource scene = family();
  const Answers ours = answers(scene, RayKind::kRandom, false);
  std::vector<scenegraph::RayTally> tallies(ours.rays.size());
  ASSERT_TRUE(scenegraph::count_hits(*ours.snapshot, ours.rays, tallies,
                                     {.kind = scenegraph::QueryKind::kCount})
                  .ok());
  EmbreeSettings settings;
  settings.crossings = true;
  auto peer = EmbreePeer::make(scene, settings, 2);
  ASSERT_TRUE(peer.ok());
  ASSERT_TRUE((*peer)->build().ok());
  std::vector<std::uint32_t> counts(ours.rays.size());
  (*peer)->count(ours.rays, counts);
  std::size_t equal = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) equal += counts[i] == tallies[i].count;
  EXPECT_GE(equal * 100, counts.size() * 99);
}

TEST(Disagreement, CountsUnexplainedDifferences) {
  const SceneSource scene = family();
  const Answers ours = answers(scene, RayKind::kRandom, false);
  std::vector<accel::geometry::Hit> theirs = ours.hits;
  std::uint64_t spoiled = 0;
  for (std::size_t i = 0; i < theirs.size(); i += 10) {
    if (theirs[i].state != accel::geometry::HitState::kHit) continue;
    theirs[i] = {};
    ++spoiled;
  }
  ASSERT_GT(spoiled, 10u);
  const Disagreement d = explain(ours.snapshot, ours.rays, ours.hits, theirs, false);
  EXPECT_EQ(d.differences, spoiled);
  EXPECT_EQ(d.checked, spoiled);
  EXPECT_EQ(d.unexplained, spoiled);
}

}  // namespace
}  // namespace sightline::bench

// What is dropped when the memory budget is used up, and in which order.
#include "server/scenes/reclaim.h"

#include <gtest/gtest.h>

#include <future>
#include <string>
#include <thread>

#include "accel/kdtree/epoch.h"
#include "scenegraph/trace.h"
#include "server/scenes/eviction_thread.h"
#include "tests/scenegraph/put_node.h"
#include "tests/server/blobs/blob_of.h"
#include "tests/support/scenes.h"
#include "tests/support/sleep_shortly.h"

namespace sightline::server::scenes {
namespace {

using exec::Held;
using scenegraph::model::PatchVertices;
using scenegraph::model::Update;

class ReclaimerTest : public testing::Test {
 protected:
  std::shared_ptr<const scenegraph::model::Mesh> upload(std::uint32_t which) {
    tests::TestMesh mesh = tests::planar_sheet(80);
    mesh.vertices.front().z = static_cast<float>(which);
    const std::string blob = tests::blob_of(mesh);
    const auto upload = *blobs_.begin(tests::digest_of(blob), 0, {"robot", "robot:1"});
    EXPECT_TRUE(upload->append(0, tests::bytes_of(blob)));
    return *blobs_.complete(upload);
  }
  std::shared_ptr<StoredScene> make_scene(const std::string& id, std::uint32_t mesh) {
    const auto scene = *scenes_.create({"projects/p/scenes/" + id});
    EXPECT_TRUE(scene->apply({tests::put_node(-1, 0, upload(mesh))}, compute_));
    return scene;
  }
  void build(StoredScene& scene) {
    const accel::geometry::Ray ray{{5, 5, 9}, {0, 0, -1}};
    accel::geometry::Hit hit;
    scene.touch();
    EXPECT_TRUE(scenegraph::trace(*scene.snapshot(), {&ray, 1}, {&hit, 1},
                                  {.growth = scenegraph::Growth::kFull}));
  }
  /// Until the tasks that free what updates have replaced are done.
  void await_background() {
    std::promise<void> done;
    compute_.enqueue_background([&] { done.set_value(); });
    done.get_future().wait();
  }
  static std::uint64_t built(const StoredScene& scene) {
    return scenegraph::revision::summarize_build(*scene.snapshot()).triangles_built;
  }
  /// Bytes that reclaim() must drop exactly `bytes` for.
  std::uint64_t bytes_to_drop(std::uint64_t bytes) {
    accel::kdtree::reclaim();
    reclaimer_.measure();
    return memory_.budget() - memory_.used() + bytes;
  }

  exec::MemoryAccount memory_{std::uint64_t{1} << 30};
  SceneStore scenes_{memory_};
  blobs::BlobStore blobs_{memory_, {.fresh = std::chrono::seconds(0)}};
  RevisionPins pins_{memory_.budget()};
  Reclaimer reclaimer_{memory_, scenes_, blobs_, pins_};
  exec::Compute compute_{1};
};

TEST_F(ReclaimerTest, MeasuresTrees) {
  const auto scene = make_scene("a", 1);
  reclaimer_.measure();
  const std::uint64_t before = memory_.used(Held::kTrees);
  build(*scene);
  reclaimer_.measure();
  EXPECT_GT(memory_.used(Held::kTrees), before + 80 * 80 * 2 * 8);
}

TEST_F(ReclaimerTest, DropsTheTreesOfTheScenesCastAtLongestAgo) {
  const auto first = make_scene("a", 1), second = make_scene("b", 2);
  for (const auto& scene : {second, first}) {
    build(*scene);
    scene->drop_old_revisions();
  }
  reclaimer_.reclaim(bytes_to_drop(1));
  EXPECT_EQ(built(*second), 0u);
  EXPECT_GT(built(*first), 0u);
  reclaimer_.reclaim(memory_.budget());
  EXPECT_EQ(built(*first), 0u);
  EXPECT_EQ(first->snapshot()->revision(), 1u);
  build(*first);
  EXPECT_GT(built(*first), 0u);
}

TEST_F(ReclaimerTest, EvictsPiecesBeforeItDropsWholeTrees) {
  const auto scene = make_scene("a", 1);
  scene->drop_old_revisions();
  build(*scene);
  const std::uint64_t full = memory_.used(Held::kTrees);
  reclaimer_.reclaim(bytes_to_drop(1));
  EXPECT_EQ(reclaimer_.evictions(), 0u);
  EXPECT_GT(memory_.trees()->evictions(), 0u);
  EXPECT_LT(memory_.used(Held::kTrees), full);
  reclaimer_.reclaim(memory_.budget());
  EXPECT_GT(reclaimer_.evictions(), 0u);
}

TEST_F(ReclaimerTest, TreesOfPatchedMeshesAreEvicted) {
  const auto scene = make_scene("a", 1);
  ASSERT_TRUE(scene->apply({PatchVertices{{1}, 0, {{0, 0, 1}}}}, compute_));
  await_background();
  build(*scene);
  ASSERT_GT(built(*scene), 0u);
  reclaimer_.evict_to_low_water();
  EXPECT_GT(built(*scene), 0u) << "there is room";
  const auto others = memory_.record(Held::kNodes, memory_.budget());
  EXPECT_GT(reclaimer_.evict_to_low_water(), 0u);
  EXPECT_EQ(built(*scene), 0u);
}

TEST_F(ReclaimerTest, AThreadEvictsWhenTreesRequestIt) {
  const auto scene = make_scene("a", 1);
  build(*scene);
  ASSERT_GT(built(*scene), 0u);
  const EvictionThread evicting(reclaimer_, *memory_.trees());
  const auto others = memory_.record(Held::kNodes, memory_.budget());
  memory_.trees()->request_eviction();
  while (memory_.trees()->evictions() == 0) tests::sleep_shortly();
  scene->touch();
  const accel::geometry::Ray ray{{5, 5, 9}, {0, 0, -1}};
  accel::geometry::Hit hit;
  EXPECT_TRUE(scenegraph::trace(*scene->snapshot(), {&ray, 1}, {&hit, 1},
                                {.growth = scenegraph::Growth::kFirstTouch}));
  EXPECT_EQ(hit.state, accel::geometry::HitState::kHit);
}

TEST_F(ReclaimerTest, DropsOldRevisionsAndUnusedMeshesBeforeTrees) {
  const auto scene = make_scene("a", 1);
  for (int i = 0; i < 5; ++i)
    ASSERT_TRUE(scene->apply({PatchVertices{{1}, 0, {{0, 0, 1}}}}, compute_));
  build(*scene);
  await_background();
  const std::uint64_t patches = memory_.used(Held::kPatches);
  ASSERT_TRUE(scene->at(3));
  reclaimer_.reclaim(bytes_to_drop(1));
  EXPECT_FALSE(scene->at(3));
  EXPECT_LT(memory_.used(Held::kPatches), patches);
  EXPECT_GT(built(*scene), 0u);

  const std::uint64_t meshes = memory_.used(Held::kMeshes);
  reclaimer_.reclaim(bytes_to_drop(1));
  EXPECT_LT(memory_.used(Held::kMeshes), meshes)
      << "the scene has its own copy since it was patched";
  EXPECT_GT(built(*scene), 0u);
}

TEST_F(ReclaimerTest, KeepsTheNewestUpdates) {
  const auto scene = make_scene("a", 1);
  for (int i = 0; i < 40; ++i) ASSERT_TRUE(scene->apply({}, compute_));
  reclaimer_.reclaim(memory_.budget());
  EXPECT_FALSE(scene->log().find(41 - kMinLogged));
  EXPECT_TRUE(scene->log().find(42 - kMinLogged));
}

}  // namespace
}  // namespace sightline::server::scenes

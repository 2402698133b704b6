// What readers hold of revisions that a scene does not keep any more.
#include "server/scenes/past_revisions.h"

#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "server/scenes/applied_updates.h"
#include "server/scenes/stored_scene.h"
#include "tests/scenegraph/put_node.h"
#include "tests/support/scenes.h"

namespace sightline::server::scenes {
namespace {

using exec::Held;
using scenegraph::model::SetTransforms;
using scenegraph::model::Update;

constexpr std::size_t kNodes = 300;

class PastRevisionsTest : public testing::Test {
 protected:
  PastRevisionsTest() {
    const tests::TestMesh cube = tests::cube();
    const auto mesh = *scenegraph::model::Mesh::make(cube.vertices, cube.faces);
    std::vector<Update> nodes;
    for (std::size_t i = 0; i < kNodes; ++i)
      nodes.push_back(tests::put_node(-1 - static_cast<std::int64_t>(i), 0, mesh));
    apply(std::move(nodes));
  }
  void apply(std::vector<Update> updates) {
    ASSERT_TRUE(scene_->apply(std::move(updates), compute_));
  }
  /// Moves the first nodes.
  void move(std::size_t nodes) {
    SetTransforms moved;
    for (std::size_t i = 1; i <= nodes; ++i) moved.nodes.push_back(static_cast<std::int64_t>(i));
    moved.parent_from_local.assign(nodes, {{1, 0, 0, ++x_, 0, 1, 0, 0, 0, 0, 1, 0}});
    apply({moved});
  }
  /// Until the tasks that free what updates have replaced are done: they hold the scene, too.
  void await_background() {
    std::promise<void> done;
    compute_.enqueue_background([&] { done.set_value(); });
    done.get_future().wait();
    // A task that takes long, as on a busy machine, is overtaken; it has the scene until it ends.
    while (scene_.use_count() > 1) std::this_thread::yield();
  }
  void delete_scene() {
    await_background();
    scene_ = nullptr;
  }
  std::uint64_t held() {
    await_background();
    scene_->release_gone();
    return scene_->past().bytes();
  }

  double x_ = 0;
  exec::MemoryAccount memory_{std::uint64_t{1} << 30};
  exec::Compute compute_{1};
  std::shared_ptr<StoredScene> scene_ =
      std::make_shared<StoredScene>(SceneInfo{.name = "projects/p/scenes/s"}, memory_);
};

TEST_F(PastRevisionsTest, ARevisionThatTheSceneKeepsCostsItsReaderNothing) {
  const auto pinned = scene_->snapshot();
  for (int i = 0; i < 10; ++i) move(kNodes);
  EXPECT_EQ(held(), 0u);
}

TEST_F(PastRevisionsTest, ARevisionCountsUntilItsLastReaderHasGone) {
  auto pinned = scene_->snapshot();
  auto second = pinned;
  move(kNodes);
  scene_->drop_old_revisions();
  const std::uint64_t bytes = held();
  EXPECT_GE(bytes, bytes_of_replaced(kNodes));
  EXPECT_GE(memory_.used(Held::kRevisions), bytes);
  EXPECT_EQ(scene_->past().bytes(pinned->revision()), bytes);
  pinned = nullptr;
  EXPECT_EQ(held(), bytes);
  second = nullptr;
  EXPECT_EQ(held(), 0u);
  EXPECT_EQ(memory_.used(Held::kRevisions), 0u);
}

TEST_F(PastRevisionsTest, EachRevisionHasItsOwnBytes) {
  std::vector<std::shared_ptr<const scenegraph::revision::Snapshot>> pins;
  for (int i = 0; i < 20; ++i) {
    pins.push_back(scene_->snapshot());
    move(kNodes);
  }
  scene_->drop_old_revisions();
  EXPECT_GE(held(), 20 * bytes_of_replaced(kNodes));
  pins.clear();
  EXPECT_EQ(held(), 0u);
}

/// Of the revisions after it only the nodes that it has still count, and each of them once.
TEST_F(PastRevisionsTest, AReaderPaysForWhatItsRevisionHoldsAlone) {
  const auto pinned = scene_->snapshot();
  for (int i = 0; i < 2000; ++i) move(3);
  scene_->drop_old_revisions();
  const std::uint64_t bytes = held();
  EXPECT_GE(bytes, bytes_of_replaced(3));
  EXPECT_LT(bytes, std::uint64_t{200} << 10) << "and not 2,000 times three nodes";
  // All nodes, in revisions that are gone: the pin has the old ones.
  move(kNodes);
  scene_->drop_old_revisions();
  EXPECT_GE(held(), bytes_of_replaced(kNodes));
}

TEST_F(PastRevisionsTest, WhatReadersHaveOfADeletedSceneCounts) {
  auto pinned = scene_->snapshot();
  const std::uint64_t of_scene = memory_.used(Held::kNodes);
  delete_scene();
  EXPECT_EQ(memory_.used(Held::kNodes), 0u);
  EXPECT_GE(memory_.used(Held::kRevisions), of_scene);
  memory_.release_gone();
  EXPECT_GE(memory_.used(Held::kRevisions), of_scene);
  pinned = nullptr;
  memory_.release_gone();
  EXPECT_EQ(memory_.used(), 0u);
}

TEST_F(PastRevisionsTest, ASceneWithoutReadersLeavesNothing) {
  move(kNodes);
  delete_scene();
  EXPECT_EQ(memory_.used(), 0u);
}

}  // namespace
}  // namespace sightline::server::scenes

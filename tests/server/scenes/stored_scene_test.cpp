// A scene and its listeners.
#include "server/scenes/stored_scene.h"

#include <gtest/gtest.h>

#include "server/codec/update_parts.h"
#include "tests/scenegraph/put_node.h"
#include "tests/support/scenes.h"

namespace sightline::server::scenes {
namespace {

using scenegraph::model::PatchVertices;
using scenegraph::model::Update;

class StoredSceneTest : public testing::Test {
 protected:
  Result<scenegraph::Applied> apply(std::vector<Update> updates) {
    return scene_->apply(std::move(updates), compute_);
  }

  exec::MemoryAccount memory_{std::uint64_t{1} << 30};
  const std::shared_ptr<StoredScene> scene_ =
      std::make_shared<StoredScene>(SceneInfo{.name = "projects/p/scenes/s"}, memory_);
  exec::Compute compute_{1};
};

TEST_F(StoredSceneTest, AnUpdateIsInTheLogBeforeListenersAreNotified) {
  std::uint64_t seen = 0;
  const auto listener = scene_->events().subscribe([&] {
    seen = scene_->log().last();
    EXPECT_EQ(seen, scene_->snapshot()->revision());
  });
  ASSERT_TRUE(apply({tests::put_node(-1, 0, nullptr)}));
  EXPECT_EQ(seen, 1u);
  const Record record = *scene_->log().find(1);
  std::string_view parts = record.bytes();
  v1::WatchSceneResponse logged;
  codec::take_part(parts, logged);
  EXPECT_EQ(logged.updates(0).put_node().node(), 1);
  EXPECT_FALSE(apply({tests::put_node(99, 0, nullptr)}));
  EXPECT_EQ(scene_->log().last(), 1u) << "a failed update is not in the log";
  scene_->events().unsubscribe(listener);
  ASSERT_TRUE(apply({}));
  EXPECT_EQ(seen, 1u);
}

TEST_F(StoredSceneTest, KeepsRevisionsWithinALimitOfBytes) {
  const tests::TestMesh sheet = tests::planar_sheet(700);
  const auto mesh = *scenegraph::model::Mesh::make(sheet.vertices, sheet.faces);
  ASSERT_TRUE(apply({tests::put_node(-1, 0, mesh)}));
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(apply({PatchVertices{{1}, 0, {{1, 2, 3}}}}));
  EXPECT_TRUE(scene_->at(31));
  EXPECT_TRUE(scene_->at(30));
  const auto old = scene_->at(2);
  ASSERT_FALSE(old) << "29 times 5.9 MB of vertices";
  EXPECT_EQ(old.error().code, Code::kOutOfRange);
  scene_->drop_old_revisions();
  EXPECT_FALSE(scene_->at(30));
  EXPECT_TRUE(scene_->at(31));
  ASSERT_TRUE(apply({}));
  EXPECT_TRUE(scene_->at(31));
}

TEST_F(StoredSceneTest, AnUpdateThatCannotBeRecordedIsNotApplied) {
  ASSERT_TRUE(apply({tests::put_node(-1, 0, nullptr)}));
  const auto fail = [](const scenegraph::Applied&) { throw std::bad_alloc(); };
  EXPECT_THROW(scene_->apply({tests::put_node(-1, 1, nullptr)}, compute_, {.before_publish = fail}),
               std::bad_alloc);
  EXPECT_EQ(scene_->snapshot()->revision(), 1u);
  EXPECT_EQ(scene_->log().last(), 1u);
  const auto applied = apply({tests::put_node(-1, 1, nullptr)});
  ASSERT_TRUE(applied);
  EXPECT_EQ(applied->revision, 2u);
  EXPECT_EQ(applied->nodes, (std::vector<scenegraph::model::NodeId>{2})) << "no id was lost";
}

TEST_F(StoredSceneTest, RefusesUpdatesAfterItsRemoval) {
  scene_->remove();
  const auto refused = apply({});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kNotFound);
  EXPECT_EQ(refused.error().reason, "SCENE_NOT_FOUND");
}

}  // namespace
}  // namespace sightline::server::scenes

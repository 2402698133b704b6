// Who pays for old revisions, and whose pins end.
#include "server/scenes/revision_pins.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <future>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/scenegraph/put_node.h"
#include "tests/support/scenes.h"

namespace sightline::server::scenes {
namespace {

using scenegraph::model::SetTransforms;
using scenegraph::model::Update;

constexpr std::size_t kMovedNodes = 200;

/// A stream that has a revision.
struct Reader {
  RevisionPins::SnapshotPointer revision;
  exec::PeerWait rest;
  bool in_work = false;
  std::string ended_with;
};

class RevisionPinsTest : public testing::Test {
 protected:
  RevisionPinsTest() {
    const tests::TestMesh cube = tests::cube();
    const auto mesh = *scenegraph::model::Mesh::make(cube.vertices, cube.faces);
    std::vector<Update> nodes;
    for (std::size_t i = 0; i < kMovedNodes; ++i)
      nodes.push_back(tests::put_node(-1 - static_cast<std::int64_t>(i), 0, mesh));
    EXPECT_TRUE(scene_->apply(std::move(nodes), compute_));
  }
  /// A reader of the newest revision, which rests; then the scene moves on.
  std::unique_ptr<Reader> pin(RevisionPins& pins, const std::string& principal) {
    auto reader = std::make_unique<Reader>();
    reader->revision = scene_->snapshot();
    reader->rest.begin(std::chrono::hours(1));
    pins.enter(reader.get(), {.caller = {principal, principal + ":1"},
                              .scene = scene_,
                              .revision = reader->revision,
                              .rest = &reader->rest,
                              .let_go = [reader = reader.get()](const Error& error) {
                                if (reader->in_work) return RevisionPins::SnapshotPointer();
                                reader->ended_with = error.message;
                                EXPECT_EQ(error.code, Code::kResourceExhausted);
                                EXPECT_EQ(error.reason, "REVISION_LET_GO");
                                return std::move(reader->revision);
                              }});
    SetTransforms moved;
    for (std::size_t i = 1; i <= kMovedNodes; ++i)
      moved.nodes.push_back(static_cast<std::int64_t>(i));
    moved.parent_from_local.assign(kMovedNodes, {{1, 0, 0, ++x_, 0, 1, 0, 0, 0, 0, 1, 0}});
    EXPECT_TRUE(scene_->apply({moved}, compute_));
    return reader;
  }
  /// Of one pin.
  std::uint64_t bytes_of_one() {
    RevisionPins pins(std::uint64_t{1} << 30);
    const auto reader = pin(pins, "probe");
    EXPECT_EQ(pins.bytes(), 0u) << "the scene keeps it";
    scene_->drop_old_revisions();
    const std::uint64_t bytes = pins.bytes();
    pins.leave(reader.get());
    EXPECT_EQ(pins.bytes(), 0u);
    return bytes;
  }

  double x_ = 0;
  exec::MemoryAccount memory_{std::uint64_t{1} << 30};
  exec::Compute compute_{1};
  std::shared_ptr<StoredScene> scene_ =
      std::make_shared<StoredScene>(SceneInfo{.name = "projects/p/scenes/s"}, memory_);
};

TEST_F(RevisionPinsTest, TheOldestOfWhomPaysMostEndsFirst) {
  RevisionPins pins(std::uint64_t{1} << 30);
  const auto first = pin(pins, "few");
  const auto second = pin(pins, "many"), third = pin(pins, "many");
  scene_->drop_old_revisions();
  second->in_work = true;
  EXPECT_TRUE(pins.end_one());
  EXPECT_TRUE(second->ended_with.empty()) << "it is in work";
  EXPECT_NE(third->ended_with.find("the memory budget of 1073741824 bytes"), std::string::npos);
  EXPECT_NE(third->ended_with.find("open the stream again"), std::string::npos);
  EXPECT_TRUE(first->ended_with.empty());
  second->in_work = false;
  EXPECT_TRUE(pins.end_one());
  EXPECT_TRUE(pins.end_one());
  EXPECT_FALSE(first->ended_with.empty());
  EXPECT_FALSE(pins.end_one());
  EXPECT_EQ(pins.ended(), 3u);
  scene_->release_gone();
  EXPECT_EQ(scene_->past().bytes(), 0u);
}

TEST_F(RevisionPinsTest, APinThatPaysNothingIsLeft) {
  RevisionPins pins(std::uint64_t{1} << 30);
  const auto reader = pin(pins, "robot");
  EXPECT_FALSE(pins.end_one());
  scene_->drop_old_revisions();
  EXPECT_TRUE(pins.end_one());
}

TEST_F(RevisionPinsTest, APrincipalHasItsShare) {
  RevisionPins pins(bytes_of_one() * 4 * kPinsShare);
  std::vector<std::unique_ptr<Reader>> many;
  for (int i = 0; i < 3; ++i) many.push_back(pin(pins, "many"));
  const auto other = pin(pins, "other");
  scene_->drop_old_revisions();
  pins.end_over_shares();
  for (const auto& reader : many) EXPECT_TRUE(reader->ended_with.empty());
  many.push_back(pin(pins, "many"));
  scene_->drop_old_revisions();
  pins.end_over_shares();
  EXPECT_NE(many[0]->ended_with.find("the limit is"), std::string::npos) << many[0]->ended_with;
  for (int i = 1; i < 4; ++i) EXPECT_TRUE(many[i]->ended_with.empty());
  EXPECT_TRUE(other->ended_with.empty());
}

TEST_F(RevisionPinsTest, WhoReadsADeletedSceneKeepsItAll) {
  RevisionPins pins(std::uint64_t{1} << 30);
  const auto reader = pin(pins, "robot");
  std::promise<void> done;  // of the tasks that hold the scene, too
  compute_.enqueue_background([&] { done.set_value(); });
  done.get_future().wait();
  scene_ = nullptr;
  EXPECT_GT(pins.bytes(), kMovedNodes * 256);
  EXPECT_TRUE(pins.end_one());
  memory_.release_gone();
  EXPECT_EQ(memory_.used(), 0u);
}

}  // namespace
}  // namespace sightline::server::scenes

// A scene to which other servers write, too: what becomes of writes that conflict with theirs.
#include "server/scenes/scene_follower.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/scenegraph/put_node.h"
#include "tests/server/scenes/journaled_scene.h"

namespace sightline::server::scenes {
namespace {

using scenegraph::model::DeleteNode;
using scenegraph::model::Update;

tests::FakeJournal::Entry request_entry(const std::string& id, std::uint64_t content) {
  tests::FakeJournal::Entry entry;
  entry.request_id = id;
  entry.content = content;
  return entry;
}

class SceneFollowerTest : public tests::JournaledScene {
 protected:
  SceneFollowerTest() : JournaledScene(std::make_shared<Replica>()) {}

  struct Outcome {
    std::optional<scenegraph::Applied> applied;  ///< The last that was reported.
    std::optional<Error> rejected;
    bool repeated = false;
    std::optional<Result<Durability>> answer;

    bool committed() const { return answer && *answer; }
    std::string error() const { return answer && !*answer ? answer->error().reason : ""; }
  };

  std::shared_ptr<Outcome> write(std::vector<Update> updates, SceneWrite write = {},
                                 std::optional<std::uint64_t> expected = {},
                                 const std::atomic<bool>* cancelled = nullptr) {
    auto outcome = std::make_shared<Outcome>();
    write.answer = [outcome](const Result<Durability>& kept) { outcome->answer = kept; };
    write.rejected = [outcome](const Error& error) { outcome->rejected = error; };
    write.repeated = [outcome](const scenegraph::Applied& earlier) {
      outcome->applied = earlier;
      outcome->repeated = true;
    };
    const auto reported = [outcome](const scenegraph::Applied& next) { outcome->applied = next; };
    on_queue([&] {
      const auto applied = scene_->apply(
          std::move(updates), compute_,
          {.expected_revision = expected, .before_publish = reported, .cancelled = cancelled},
          write);
      EXPECT_TRUE(applied);
    });
    return outcome;
  }
  std::shared_ptr<Outcome> put(const SceneWrite& write = {}) {
    return this->write({tests::put_node(-1, 0, nullptr)}, write);
  }
  /// The request of a write that waits comes again.
  std::shared_ptr<Outcome> repeat(const std::string& id, std::uint64_t content) {
    auto outcome = std::make_shared<Outcome>();
    on_queue([&] {
      const auto known = scene_->find_earlier(
          id, content,
          [outcome](const scenegraph::Applied& earlier, const Result<Durability>& kept) {
            outcome->applied = earlier;
            outcome->answer = kept;
          });
      EXPECT_TRUE(known && *known);
    });
    return outcome;
  }
  /// Another server puts nodes.
  void others_put(std::size_t nodes = 1, tests::FakeJournal::Entry entry = {}) {
    std::vector<Update> updates;
    for (std::size_t i = 0; i < nodes; ++i) {
      updates.push_back(tests::put_node(-1 - static_cast<std::int64_t>(i), 0, nullptr));
      entry.nodes.push_back(++others_last_);
    }
    journal_->commit_of_others(std::move(updates), std::move(entry));
  }

  scenegraph::model::NodeId others_last_ = 0;
};

TEST_F(SceneFollowerTest, PublishesWhatOthersCommit) {
  others_put();
  others_put(2);
  int reported = 0;
  scene_->events().subscribe([&] { ++reported; });
  scene_->follower()->note(2, compute_);
  on_queue([] {});
  EXPECT_EQ(revision(), 2u);
  EXPECT_EQ(reported, 2);
  EXPECT_EQ(scene_->log().last(), 2u);
  EXPECT_EQ(scene_->snapshot()->node_count(), 3u);
  EXPECT_EQ(replica_->tallies.revisions_followed, 2u);
  EXPECT_EQ(scene_->follower()->lag().revisions, 0u);
}

TEST_F(SceneFollowerTest, AConflictingWriteIsAppliedAgain) {
  const auto first = put(), second = put();
  others_put(3);
  commit();  // the first fails, and both are retried
  EXPECT_EQ(revision(), 1u);
  EXPECT_FALSE(first->answer);
  EXPECT_EQ(first->applied->nodes.front(), 4u);
  EXPECT_EQ(second->applied->nodes.front(), 5u);
  commit();  // of the second, as it was at first: it fails, and no caller waits for it
  commit();
  commit();
  EXPECT_TRUE(first->committed());
  EXPECT_TRUE(second->committed());
  EXPECT_EQ(first->applied->revision, 2u);
  EXPECT_EQ(second->applied->revision, 3u);
  EXPECT_EQ(revision(), 3u);
  EXPECT_EQ(replica_->tallies.writes_repeated, 2u);
}

TEST_F(SceneFollowerTest, AWriteNamesTheOneOnWhichItBuilds) {
  put();
  put();
  const auto waiting = journal_->waiting();
  EXPECT_EQ(waiting[0].after, nullptr);
  EXPECT_EQ(waiting[1].after, waiting[0].outcome);
}

TEST_F(SceneFollowerTest, AnExpectedRevisionIsNotTriedAgain) {
  const auto expected = write({tests::put_node(-1, 0, nullptr)}, {}, 0), other = put();
  others_put();
  commit();
  EXPECT_EQ(expected->error(), "REVISION_MISMATCH");
  EXPECT_FALSE(other->answer);
  commit();
  commit();
  EXPECT_TRUE(other->committed());
}

TEST_F(SceneFollowerTest, AWriteFailsAtLast) {
  const auto contended = put();
  for (int i = 0; i < kMaxTries; ++i) {
    EXPECT_FALSE(contended->answer);
    others_put();
    commit();
  }
  EXPECT_EQ(contended->error(), "WRITE_CONTENDED");
  EXPECT_EQ(revision(), static_cast<std::uint64_t>(kMaxTries));
  EXPECT_EQ(replica_->tallies.writes_failed, 1u);
}

TEST_F(SceneFollowerTest, AWriteIsAppliedAgainThoughItsCallerHasGone) {
  std::atomic<bool> cancelled{false};
  const auto mine = write({tests::put_node(-1, 0, nullptr)}, {.request_id = "a", .content = 1}, {},
                          &cancelled),
             behind = put();
  const auto repeated = repeat("a", 1);
  cancelled = true;
  others_put();
  while (journal_->queued() > 0) commit();
  EXPECT_TRUE(mine->committed());
  EXPECT_TRUE(repeated->committed());
  EXPECT_TRUE(behind->committed());
  EXPECT_EQ(revision(), 3u);
}

TEST_F(SceneFollowerTest, ARequestThatIsRepeatedBeforeItIsAppliedAgainGetsTheLastAnswer) {
  const auto first = put({.request_id = "a", .content = 1}), repeated = repeat("a", 1);
  others_put(3);
  while (journal_->queued() > 0) commit();
  ASSERT_TRUE(repeated->committed());
  EXPECT_EQ(repeated->applied->revision, 2u);
  EXPECT_EQ(repeated->applied->nodes.front(), 4u);
  EXPECT_EQ(first->applied->revision, 2u);
}

TEST_F(SceneFollowerTest, ARepeatedRequestThatAnotherServerHasGotFirstGetsItsAnswer) {
  const auto first = put({.request_id = "a", .content = 1}), repeated = repeat("a", 1);
  others_put(3);
  others_put(1, request_entry("a", 1));
  commit();
  ASSERT_TRUE(repeated->committed());
  EXPECT_EQ(repeated->applied->revision, 2u);
  EXPECT_EQ(repeated->applied->nodes.front(), 4u);
  EXPECT_TRUE(first->repeated);
}

TEST_F(SceneFollowerTest, ARequestThatAnotherServerHasGotFirstGetsItsAnswer) {
  const auto request = put({.request_id = "a", .content = 1}),
             reused = put({.request_id = "b", .content = 1});
  others_put(1, request_entry("a", 1));
  others_put(1, request_entry("b", 2));
  commit();
  EXPECT_TRUE(request->committed());
  EXPECT_TRUE(request->repeated);
  EXPECT_EQ(request->applied->revision, 1u);
  EXPECT_EQ(reused->error(), "REQUEST_ID_REUSED");
  EXPECT_EQ(revision(), 2u);
}

TEST_F(SceneFollowerTest, WaitsForAllWritesThoughTheLastIsAnsweredFirst) {
  const auto first = put(), known = put({.request_id = "a", .content = 1});
  bool answered = false, committed = false;
  on_queue([&] {
    scene_->when_answered([&] { answered = true; });
    scene_->when_committed([&](const Status& status) { committed = status.ok(); });
  });
  others_put(1, request_entry("a", 1));
  commit();
  EXPECT_TRUE(known->committed());
  EXPECT_FALSE(first->answer);
  EXPECT_FALSE(answered);
  EXPECT_FALSE(committed);
  while (journal_->queued() > 0) commit();
  EXPECT_TRUE(first->committed());
  EXPECT_TRUE(answered);
  EXPECT_TRUE(committed);
}

TEST_F(SceneFollowerTest, ABatchThatAnotherServerHasGotFirstIsARepeat) {
  Producer* producer = nullptr;
  on_queue([&] { producer = *scene_->producers().open("robot"); });
  const auto first = put({.producer = producer, .first_sequence = 1}),
             second = put({.producer = producer, .first_sequence = 2});
  tests::FakeJournal::Entry entry;
  entry.producer = "robot";
  entry.batches = {{1, {1}}};
  others_put(1, std::move(entry));
  commit();
  EXPECT_TRUE(first->committed());
  EXPECT_TRUE(first->repeated);
  EXPECT_EQ(first->applied->nodes.front(), 1u);
  EXPECT_EQ(producer->last_committed, 1u);
  commit();
  commit();
  EXPECT_TRUE(second->committed());
  EXPECT_FALSE(second->repeated);
  EXPECT_EQ(second->applied->nodes.front(), 2u);
  EXPECT_EQ(producer->last_committed, 2u);
}

TEST_F(SceneFollowerTest, AWriteThatHasBecomeInvalidIsRefusedAlone) {
  others_put(2);
  scene_->follower()->note(1, compute_);
  on_queue([] {});
  Producer* producer = nullptr;
  on_queue([&] { producer = *scene_->producers().open("robot"); });
  const auto refused = write({DeleteNode{1, false}}),
             rejected = write({DeleteNode{2, false}}, {.producer = producer, .first_sequence = 1}),
             good = put();
  journal_->commit_of_others({DeleteNode{1, false}, DeleteNode{2, false}});
  commit();
  EXPECT_EQ(refused->error(), "NODE_NOT_FOUND");
  EXPECT_TRUE(rejected->rejected);
  while (journal_->queued() > 0) commit();
  EXPECT_TRUE(rejected->committed());
  EXPECT_EQ(producer->last_committed, 1u);
  EXPECT_TRUE(good->committed());
  EXPECT_EQ(revision(), 3u);
}

TEST_F(SceneFollowerTest, ARelaxedWriteWaitsForItsCommit) {
  const auto relaxed = put({.relaxed = true});
  EXPECT_FALSE(relaxed->answer);
  EXPECT_EQ(revision(), 0u);
  commit();
  ASSERT_TRUE(relaxed->committed());
  EXPECT_EQ(**relaxed->answer, Durability::kCommitted);
}

TEST_F(SceneFollowerTest, CatchesUpBeforeItsFirstWrite) {
  others_put();
  std::optional<bool> caught_up;
  on_queue([&] {
    scene_->follower()->when_caught_up(compute_,
                                       [&](const Status& read) { caught_up = read.ok(); });
  });
  EXPECT_EQ(caught_up, true);
  EXPECT_EQ(revision(), 1u);
}

TEST_F(SceneFollowerTest, CatchesUpAfterTheWritesThatWait) {
  const auto mine = put();
  std::optional<bool> caught_up;
  on_queue([&] {
    scene_->follower()->when_caught_up(compute_,
                                       [&](const Status& read) { caught_up = read.ok(); });
  });
  EXPECT_FALSE(caught_up);
  commit();
  on_queue([] {});
  EXPECT_EQ(caught_up, true);
  EXPECT_TRUE(mine->committed());
}

}  // namespace
}  // namespace sightline::server::scenes

// Writes of a scene that a journal keeps: when readers see them, who is told, and what a failure
// leaves.
#include <gtest/gtest.h>

#include <memory>
#include <optional>

#include "server/scenes/applied_updates.h"
#include "tests/scenegraph/put_node.h"
#include "tests/server/scenes/journaled_scene.h"

namespace sightline::server::scenes {
namespace {

using scenegraph::model::Update;

class SceneWriteTest : public tests::JournaledScene {
 protected:
  struct Answer {
    std::optional<Result<Durability>> value;
    bool is(Durability durability) const { return value && *value && **value == durability; }
    bool is_error(const std::string& reason) const {
      return value && !*value && value->error().reason == reason;
    }
  };

  /// Puts a node; the answer is set later.
  std::shared_ptr<Answer> put(SceneWrite write = {}) {
    auto answer = std::make_shared<Answer>();
    write.answer = [answer](const Result<Durability>& kept) { answer->value = kept; };
    on_queue([&] {
      const auto applied = scene_->apply({tests::put_node(-1, 0, nullptr)}, compute_, {}, write);
      EXPECT_TRUE(applied);
    });
    return answer;
  }
  void fail() {
    journal_->fail();
    on_queue([] {});
  }
};

TEST_F(SceneWriteTest, AWriteIsPublishedAndAnsweredWhenItIsCommitted) {
  const auto first = put(), second = put();
  EXPECT_EQ(revision(), 0u);
  EXPECT_FALSE(first->value);
  commit();
  EXPECT_EQ(revision(), 1u);
  EXPECT_EQ(scene_->log().last(), 1u);
  EXPECT_TRUE(first->is(Durability::kCommitted));
  EXPECT_FALSE(second->value);
  commit();
  EXPECT_EQ(revision(), 2u);
  EXPECT_TRUE(second->is(Durability::kCommitted));
}

TEST_F(SceneWriteTest, ARelaxedWriteIsAnsweredAtOnceUnlessAnotherWaits) {
  const auto relaxed = put({.relaxed = true});
  EXPECT_EQ(revision(), 1u);
  EXPECT_TRUE(relaxed->is(Durability::kRelaxed));
  const auto strict = put(), behind = put({.relaxed = true});
  EXPECT_EQ(revision(), 1u);
  commit();
  EXPECT_EQ(revision(), 1u);
  commit();
  EXPECT_EQ(revision(), 3u);
  EXPECT_TRUE(strict->is(Durability::kCommitted));
  EXPECT_TRUE(behind->is(Durability::kRelaxed));
}

TEST_F(SceneWriteTest, AFailureLeavesNothingOfWhatIsNotCommitted) {
  put();
  commit();
  const auto failed = put(), follows = put();
  fail();
  EXPECT_EQ(revision(), 1u);
  EXPECT_TRUE(failed->is_error("DISK_FULL"));
  EXPECT_TRUE(follows->is_error("DISK_FULL"));
  commit();  // the second is refused, and was answered
  const auto later = put();
  commit();
  EXPECT_EQ(revision(), 2u);
  EXPECT_TRUE(later->is(Durability::kCommitted));
  EXPECT_EQ(scene_->snapshot()->node_count(), 2u);
  EXPECT_NE(scene_->snapshot()->find(2), nullptr) << "no id was lost";
}

TEST_F(SceneWriteTest, AWriteThatTheJournalDoesNotTakeFailsInItsTurn) {
  const auto first = put();
  journal_->refuses = true;
  const auto refused = put();
  EXPECT_FALSE(refused->value);
  commit();
  EXPECT_TRUE(first->is(Durability::kCommitted));
  EXPECT_TRUE(refused->is_error("QUEUE_FULL"));
  EXPECT_EQ(revision(), 1u);
}

TEST_F(SceneWriteTest, RelaxedWritesThatCouldNotBeCommittedAreTriedAgain) {
  put({.relaxed = true});
  put({.relaxed = true});
  fail();
  EXPECT_EQ(revision(), 2u) << "what readers have seen stays";
  on_queue([&] {
    const auto refused = scene_->apply({}, compute_);
    EXPECT_FALSE(refused) << "the second is still under way";
    EXPECT_EQ(refused.error().reason, "STORE_FAILING");
  });
  commit();  // it is refused
  const auto relaxed = put({.relaxed = true});
  EXPECT_FALSE(relaxed->value) << "it waits for its commit now";
  commit();
  EXPECT_FALSE(relaxed->value) << "it waits until the others are committed";
  commit();
  EXPECT_TRUE(relaxed->is(Durability::kRelaxed));
  commit();
  EXPECT_EQ(journal_->kept().size(), 3u);
  EXPECT_TRUE(put({.relaxed = true})->is(Durability::kRelaxed));
  commit();
}

TEST_F(SceneWriteTest, ARequestThatIsSentAgainGetsItsAnswerWhenTheFirstIsCommitted) {
  const auto first = put({.request_id = "a", .content = 1});
  std::optional<bool> repeated;
  const auto repeat = [&](std::uint64_t content) {
    return scene_->find_earlier("a", content,
                                [&](const scenegraph::Applied& earlier, const auto& kept) {
                                  EXPECT_EQ(earlier.revision, 1u);
                                  EXPECT_EQ(earlier.nodes.size(), 1u);
                                  repeated = static_cast<bool>(kept);
                                });
  };
  on_queue([&] {
    EXPECT_TRUE(*repeat(1));
    EXPECT_EQ(repeat(2).error().reason, "REQUEST_ID_REUSED");
  });
  EXPECT_FALSE(repeated);
  commit();
  EXPECT_EQ(repeated, true);
  repeated.reset();
  on_queue([&] { EXPECT_TRUE(*repeat(1)); });
  EXPECT_EQ(repeated, true);
  on_queue([&] { EXPECT_FALSE(*scene_->find_earlier("b", 1, [](const auto&, const auto&) {})); });
}

TEST_F(SceneWriteTest, ProducersAdvanceWithTheirCommits) {
  Producer* producer = nullptr;
  on_queue([&] { producer = *scene_->producers().open("robot"); });
  put({.producer = producer, .first_sequence = 1, .batches = 1});
  std::optional<bool> rejected;
  on_queue([&] {
    EXPECT_TRUE(scene_->record_rejected(
        compute_, {.producer = producer, .first_sequence = 2, .answer = [&](const auto& kept) {
                     rejected = static_cast<bool>(kept);
                   }}));
  });
  EXPECT_EQ(producer->last_committed, 0u);
  commit();
  EXPECT_EQ(producer->last_committed, 1u);
  EXPECT_FALSE(rejected);
  commit();
  EXPECT_EQ(producer->last_committed, 2u);
  EXPECT_EQ(rejected, true);
  EXPECT_EQ(revision(), 1u);
}

TEST_F(SceneWriteTest, AWriteBehindARejectedBatchIsAppendedWhenThatIsCommitted) {
  Producer* producer = nullptr;
  on_queue([&] { producer = *scene_->producers().open("robot"); });
  std::optional<bool> rejected;
  const auto reject = [&](std::uint64_t sequence) {
    on_queue([&] {
      EXPECT_TRUE(scene_->record_rejected(
          compute_, {.producer = producer,
                     .first_sequence = sequence,
                     .answer = [&](const auto& kept) { rejected = static_cast<bool>(kept); }}));
    });
  };
  reject(1);
  const auto follows = put();
  EXPECT_EQ(journal_->queued(), 1u);
  fail();
  EXPECT_EQ(rejected, false);
  EXPECT_TRUE(follows->is_error("DISK_FULL"));
  EXPECT_EQ(journal_->queued(), 0u) << "else it could be committed, and nobody would know";
  reject(1);
  const auto again = put(), last = put();
  commit();
  EXPECT_EQ(rejected, true);
  EXPECT_EQ(journal_->queued(), 2u);
  commit();
  commit();
  EXPECT_TRUE(again->is(Durability::kCommitted));
  EXPECT_TRUE(last->is(Durability::kCommitted));
  EXPECT_EQ(revision(), 2u);
}

TEST_F(SceneWriteTest, AFlushWaitsForRelaxedWrites) {
  const auto soon = [] { return StoredScene::Clock::now() + std::chrono::milliseconds(1); };
  scene_->flush(StoredScene::Clock::time_point::max());  // there are none
  put({.relaxed = true});
  scene_->flush(soon());
  auto flushed = std::async(std::launch::async, [&] {
    scene_->flush(StoredScene::Clock::now() + std::chrono::hours(1));
  });
  commit();
  flushed.get();
  EXPECT_EQ(journal_->kept().size(), 1u);
}

TEST_F(SceneWriteTest, WaitsForAnswersAndForCommits) {
  put({.relaxed = true});
  int answered = 0;
  std::optional<Status> committed;
  on_queue([&] {
    scene_->when_answered([&] { ++answered; });
    scene_->when_committed([&](const Status& status) { committed = status; });
  });
  EXPECT_EQ(answered, 1);
  EXPECT_FALSE(committed);
  fail();
  ASSERT_TRUE(committed);
  EXPECT_EQ(committed->error().reason, "DISK_FULL");
}

TEST_F(SceneWriteTest, ALoadedSceneIsWhatWasCommitted) {
  for (int i = 0; i < 5; ++i) put();
  for (int i = 0; i < 4; ++i) commit();
  const auto loaded =
      std::make_shared<StoredScene>(scene_->info(), memory_, KeptScene{journal_, 7, 1});
  EXPECT_FALSE(loaded->loaded());
  ASSERT_TRUE(loaded->load(compute_));
  EXPECT_EQ(loaded->snapshot()->revision(), 4u);
  EXPECT_EQ(loaded->snapshot()->node_count(), 4u);
  EXPECT_EQ(loaded->token(4).text(), scene_->token(4).text());
  EXPECT_TRUE(loaded->at(2)) << "revisions that were retained can be read";
  EXPECT_EQ(loaded->log().last(), 4u);
  commit();  // ends the wait of the last write
}

/// Those who wait while a scene is read must not go on with the part that was read.
TEST_F(SceneWriteTest, ASceneThatCouldNotBeReadIsReadByAnother) {
  for (int i = 0; i < 4; ++i) {
    put();
    commit();
  }
  exec::MemoryAccount memory(bytes_of_scene(4, 0) + 3000);
  auto hog = memory.record(exec::Held::kMeshes, 2500);
  const auto failed =
      std::make_shared<StoredScene>(scene_->info(), memory, KeptScene{journal_, 7, 4});
  ASSERT_EQ(failed->load(compute_).error().reason, exec::kMemoryBudget);
  EXPECT_GT(failed->snapshot()->revision(), 0u) << "a part was read";
  hog = {};
  EXPECT_EQ(failed->load(compute_).error().reason, exec::kMemoryBudget);
  EXPECT_TRUE(failed->failed());
  EXPECT_FALSE(failed->loaded());
  const KeptScene kept = failed->kept();
  EXPECT_EQ(kept.unread, 4u);
  EXPECT_GE(kept.node_bytes, bytes_of_scene(failed->snapshot()->node_count(), 0));
  const auto fresh = std::make_shared<StoredScene>(scene_->info(), memory_, kept);
  ASSERT_TRUE(fresh->load(compute_));
  EXPECT_EQ(fresh->snapshot()->node_count(), 4u);
}

TEST_F(SceneWriteTest, ASceneThatDidNotFitIsNotReadBeforeItMay) {
  put();
  commit();
  exec::MemoryAccount memory(std::uint64_t{1} << 20);
  const auto large = std::make_shared<StoredScene>(
      scene_->info(), memory,
      KeptScene{.journal = journal_, .unread = 1, .node_bytes = std::uint64_t{1} << 20});
  EXPECT_EQ(large->load(compute_).error().reason, exec::kMemoryBudget);
  EXPECT_EQ(large->snapshot()->revision(), 0u);
  EXPECT_FALSE(large->failed()) << "it may be read later";
}

}  // namespace
}  // namespace sightline::server::scenes

// A producer's batches: applied alone, together, and with an invalid one among them.
#include "server/updates/producer_session.h"

#include <gtest/gtest.h>

#include "tests/scenegraph/put_node.h"

namespace sightline::server::updates {
namespace {

using scenegraph::model::Affine;
using scenegraph::model::DeleteNode;
using scenegraph::model::NodeRef;
using scenegraph::model::PutNode;
using scenegraph::model::SetTransforms;
using scenegraph::model::Update;

class ProducerSessionTest : public testing::Test {
 protected:
  void SetUp() override {
    std::vector<Update> nodes;
    for (NodeRef i = 1; i <= 3; ++i) nodes.push_back(tests::put_node(-i, 0, nullptr));
    ASSERT_TRUE(scene_->apply(nodes, compute_));
  }

  void add(std::vector<Update> updates) {
    UpdateBatch batch;
    batch.sequence = ++sequence_;
    batch.updates = std::move(updates);
    batches_.push_back(std::move(batch));
  }
  void add_pose(NodeRef node, double x) {
    add({SetTransforms{{node}, {Affine{{1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0}}}}});
  }
  double x(scenegraph::model::NodeId node) const {
    return scene_->snapshot()->find(node)->parent_from_local.m[3];
  }
  /// The answers to all batches, in order.
  std::vector<BatchOutcome> apply_all(ProducerSession& session) {
    while (!batches_.empty()) {
      const Status applied = session.apply_some(batches_);
      EXPECT_TRUE(applied);
      if (!applied) break;
    }
    return std::exchange(answered_, {});
  }
  ProducerSession::Call call_of(const void* id, bool latest_wins = false,
                                const std::atomic<bool>* cancelled = nullptr) {
    return {.id = id,
            .cancelled = cancelled,
            .latest_wins = latest_wins,
            .answer = [this](const Result<Answered>& result) {
              ASSERT_TRUE(result);
              answered_.insert(answered_.end(), result->outcomes.begin(), result->outcomes.end());
            }};
  }

  exec::MemoryAccount memory_{std::uint64_t{1} << 30};
  const std::shared_ptr<scenes::StoredScene> scene_ = std::make_shared<scenes::StoredScene>(
      scenes::SceneInfo{.name = "projects/p/scenes/s"}, memory_);
  exec::Compute compute_{1};
  scenes::Producer producer_{"robot", memory_, {}};
  int call_ = 0;
  std::uint64_t sequence_ = 0;
  std::deque<UpdateBatch> batches_;
  std::vector<BatchOutcome> answered_;
};

TEST_F(ProducerSessionTest, ACancelledCallLeavesItsBatchesUnapplied) {
  const std::atomic<bool> cancelled{true};
  for (const bool latest_wins : {false, true}) {
    ProducerSession session(*scene_, producer_, call_of(&call_, latest_wins, &cancelled), compute_);
    session.take_over();
    add_pose(1, 5);
    add_pose(1, 6);
    EXPECT_EQ(session.apply_some(batches_).error().code, Code::kCancelled);
    EXPECT_EQ(producer_.last_committed, 0u);
    EXPECT_EQ(x(1), 0);
  }
}

TEST_F(ProducerSessionTest, MakesARevisionOfEachBatch) {
  ProducerSession session(*scene_, producer_, call_of(&call_), compute_);
  session.take_over();
  for (int i = 1; i <= 4; ++i) add_pose(1, i);
  const auto outcomes = apply_all(session);
  ASSERT_EQ(outcomes.size(), 4u);
  for (std::uint64_t i = 0; i < 4; ++i) EXPECT_EQ(outcomes[i].applied->revision, 2 + i);
  EXPECT_EQ(session.coalesced(), 0u);
  EXPECT_EQ(producer_.last_committed, 4u);
}

TEST_F(ProducerSessionTest, TheLatestPosesWin) {
  ProducerSession session(*scene_, producer_, call_of(&call_, true), compute_);
  session.take_over();
  for (int i = 1; i <= 4; ++i) add_pose(1 + i % 2, i);
  add({DeleteNode{3}});
  add_pose(1, 50);
  add({tests::put_node(-1, 0, nullptr), SetTransforms{{-1, 1}, {Affine{}, Affine{}}}});
  add_pose(1, 60);
  add_pose(1, 70);
  const auto outcomes = apply_all(session);
  ASSERT_EQ(outcomes.size(), 9u);
  const std::vector<std::uint64_t> revisions{2, 2, 2, 2, 3, 4, 5, 6, 6};
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_EQ(outcomes[i].sequence, i + 1);
    EXPECT_EQ(outcomes[i].applied->revision, revisions[i]) << i;
  }
  EXPECT_EQ(outcomes[6].applied->nodes, std::vector<scenegraph::model::NodeId>{4});
  EXPECT_EQ(session.coalesced(), 4u);
  EXPECT_EQ(x(1), 70);
  EXPECT_EQ(x(2), 3);
}

TEST_F(ProducerSessionTest, RejectsOnlyTheInvalidBatchOfAGroup) {
  ProducerSession session(*scene_, producer_, call_of(&call_, true), compute_);
  session.take_over();
  add_pose(1, 1);
  add_pose(99, 2);
  add_pose(1, 3);
  add_pose(2, 4);
  const auto outcomes = apply_all(session);
  ASSERT_EQ(outcomes.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(outcomes[i].applied.ok(), i != 1) << i;
  EXPECT_EQ(outcomes[1].applied.error().code, Code::kNotFound);
  EXPECT_EQ(session.coalesced(), 0u);
  EXPECT_EQ(x(1), 3);
  EXPECT_EQ(x(2), 4);
  EXPECT_EQ(producer_.last_committed, 4u);
  add_pose(1, 5);
  add_pose(1, 6);
  EXPECT_EQ(apply_all(session).size(), 2u);
  EXPECT_EQ(session.coalesced(), 1u) << "coalesced again";
}

TEST_F(ProducerSessionTest, RejectsAnUnreadableBatchInOrder) {
  ProducerSession session(*scene_, producer_, call_of(&call_, true), compute_);
  session.take_over();
  add_pose(1, 1);
  add({});
  batches_.back().bad = Error{Code::kInvalidArgument, "broken", "BROKEN"};
  add_pose(1, 2);
  const auto outcomes = apply_all(session);
  ASSERT_EQ(outcomes.size(), 3u);
  EXPECT_EQ(outcomes[1].applied.error().reason, "BROKEN");
  EXPECT_EQ(x(1), 2);
}

TEST_F(ProducerSessionTest, EndsWhenAnotherCallTakesOver) {
  ProducerSession older(*scene_, producer_, call_of(&call_), compute_);
  older.take_over();
  int newer_call = 0, events = 0;
  const auto listener = scene_->events().subscribe([&] { ++events; });
  ProducerSession newer(*scene_, producer_, call_of(&newer_call), compute_);
  newer.take_over();
  EXPECT_EQ(events, 1);
  scene_->events().unsubscribe(listener);
  add_pose(1, 1);
  const auto refused = older.apply_some(batches_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kAborted);
  older.leave();
  EXPECT_EQ(apply_all(newer).size(), 1u) << "its sequence number was kept";
  scene_->remove();
  add_pose(1, 2);
  EXPECT_EQ(newer.apply_some(batches_).error().code, Code::kNotFound);
  EXPECT_EQ(producer_.last_committed, 1u);
}

}  // namespace
}  // namespace sightline::server::updates

// StreamUpdates through a real server.
#include "server/updates/update_stream_rpc.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "server/updates/producer_messages.h"
#include "tests/server/support/live_server.h"
#include "tests/server/updates/update_stream.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

class UpdateStreamRpcTest : public LiveServer {
 protected:
  void SetUp() override { ASSERT_TRUE(api_.create(kScene).ok()); }

  /// The status of the call after it was opened and this was sent.
  grpc::Status ends_with(std::uint64_t sequence, bool more = false) {
    UpdateStream stream(api_);
    stream.open(kScene);
    stream.send(sequence, {put_node(-1)}, more);
    if (more) stream.send(sequence + 1, {put_node(-1)});
    return stream.finish();
  }

  std::uint64_t add_node() {
    v1::ApplyUpdatesResponse reply;
    EXPECT_TRUE(api_.apply(kScene, {put_node(-1, api_.add_mesh(cube()))}, &reply).ok());
    return reply.nodes(0);
  }
};

TEST_F(UpdateStreamRpcTest, AppliesBatchesInOrderAndAcksThem) {
  UpdateStream stream(api_);
  const v1::ProducerOpened opened = stream.open(kScene);
  EXPECT_EQ(opened.last_committed(), 0u);
  EXPECT_EQ(opened.window(), server::updates::kUpdateWindow);
  EXPECT_EQ(opened.revision().revision(), 0u);
  ASSERT_TRUE(stream.send(1, {put_node(-1), put_node(-2, "", -1)}));
  ASSERT_TRUE(stream.send(2, {}));
  ASSERT_TRUE(stream.send(3, {put_node(-1, "", 1)}));
  std::vector<std::uint64_t> put;
  v1::SceneRevision last;
  for (const auto& answer : stream.read_up_to(3)) {
    ASSERT_TRUE(answer.has_ack());
    last = answer.ack().revision();
    for (const v1::PutNodes& nodes : answer.ack().put())
      put.insert(put.end(), nodes.nodes().begin(), nodes.nodes().end());
  }
  EXPECT_EQ(put, (std::vector<std::uint64_t>{1, 2, 3}));
  EXPECT_EQ(last.revision(), 3u);
  EXPECT_EQ(api_.get(kScene).head().token(), last.token());
  EXPECT_EQ(api_.get(kScene).nodes(), 3u);
  stream.close();
  EXPECT_TRUE(stream.finish().ok());
}

TEST_F(UpdateStreamRpcTest, ARejectAnswersItsBatchAndTheStreamContinues) {
  {
    UpdateStream stream(api_);
    stream.open(kScene);
    stream.send(1, {put_node(-1)});
    stream.send(2, {put_node(-1), put_node(-2, "", 99)});
    stream.send(3, {put_node(-1)});
    bool rejected = false;
    for (const auto& answer : stream.read_up_to(3)) {
      if (!answer.has_reject()) continue;
      rejected = true;
      EXPECT_EQ(answer.reject().sequence(), 2u);
      EXPECT_EQ(answer.reject().code(), grpc::StatusCode::NOT_FOUND);
      EXPECT_EQ(answer.reject().reason(), "PARENT_NOT_FOUND");
      EXPECT_NE(answer.reject().message().find("update 1"), std::string::npos);
    }
    EXPECT_TRUE(rejected);
    EXPECT_EQ(api_.get(kScene).nodes(), 2u);
    stream.send(4, {put_node(0), v1::Update()});
    EXPECT_EQ(stream.read_up_to(4).back().reject().reason(), "EMPTY_UPDATE");
  }
  UpdateStream again(api_);
  EXPECT_EQ(again.open(kScene).last_committed(), 4u);
  again.send(4, {put_node(-1)});
  EXPECT_EQ(again.read_up_to(4).back().ack().up_to_sequence(), 4u)
      << "a rejected batch is not applied again";
  EXPECT_EQ(api_.get(kScene).nodes(), 2u);
}

TEST_F(UpdateStreamRpcTest, AGapEndsTheCallAndNamesBothNumbers) {
  const grpc::Status gap = ends_with(2);
  EXPECT_EQ(gap.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(reason_of(gap), "SEQUENCE_GAP");
  EXPECT_NE(gap.error_message().find("expected batch 1"), std::string::npos) << gap.error_message();
  EXPECT_NE(gap.error_message().find("got batch 2"), std::string::npos) << gap.error_message();
  EXPECT_EQ(reason_of(ends_with(0)), "SEQUENCE_GAP");
  EXPECT_EQ(reason_of(ends_with(1, true)), "BATCH_NOT_FINISHED");
  EXPECT_EQ(api_.get(kScene).nodes(), 0u);
}

TEST_F(UpdateStreamRpcTest, AnswersBatchesBeforeTheMistake) {
  UpdateStream stream(api_);
  stream.open(kScene);
  for (std::uint64_t i = 1; i <= 5; ++i) stream.send(i, {put_node(-1)});
  stream.send(9, {put_node(-1)});
  EXPECT_EQ(stream.read_up_to(5).back().ack().up_to_sequence(), 5u);
  EXPECT_EQ(reason_of(stream.finish()), "SEQUENCE_GAP");
  EXPECT_EQ(api_.get(kScene).nodes(), 5u);
}

TEST_F(UpdateStreamRpcTest, OnlyTheFirstMessageOpens) {
  UpdateStream early(api_), twice(api_), unknown(api_), nameless(api_);
  early.send(1, {});
  EXPECT_EQ(reason_of(early.finish()), "NOT_OPENED");
  twice.open(kScene);
  twice.send_open(kScene, "robot");
  EXPECT_EQ(reason_of(twice.finish()), "OPENED_TWICE");
  unknown.send_open("projects/p/scenes/none", "robot");
  EXPECT_EQ(unknown.finish().error_code(), grpc::StatusCode::NOT_FOUND);
  nameless.send_open(kScene, "");
  EXPECT_EQ(reason_of(nameless.finish()), "BAD_PRODUCER");
}

TEST_F(UpdateStreamRpcTest, RepeatsAreAcknowledgedAndSkipped) {
  UpdateStream stream(api_);
  stream.open(kScene);
  stream.send(1, {put_node(-1)});
  stream.read_up_to(1);
  for (int i = 0; i < 100; ++i) {
    stream.send(1, {put_node(-1)}, true);
    stream.send(1, {put_node(-1)});
  }
  EXPECT_EQ(stream.read_up_to(1).back().ack().up_to_sequence(), 1u);
  stream.send(2, {put_node(-1)});
  const auto answers = stream.read_up_to(2);
  ASSERT_EQ(answers.back().ack().put_size(), 1);
  EXPECT_EQ(answers.back().ack().put(0).sequence(), 2u);
  EXPECT_EQ(api_.get(kScene).nodes(), 2u);
}

TEST_F(UpdateStreamRpcTest, ABatchMaySpanSeveralMessages) {
  UpdateStream stream(api_);
  stream.open(kScene);
  for (std::int64_t i = 1; i <= 100; ++i)
    ASSERT_TRUE(stream.send(1, {put_node(-i, "", i == 1 ? 0 : -1)}, i < 100));
  const auto answers = stream.read_up_to(1);
  ASSERT_EQ(answers.back().ack().put_size(), 1);
  EXPECT_EQ(answers.back().ack().put(0).nodes_size(), 100);
  EXPECT_EQ(answers.back().ack().revision().revision(), 1u);

  const std::vector<v1::Update> many(25'000, move_to(1, 0));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(stream.send(2, many, true));
  ASSERT_TRUE(stream.send(2, {put_node(-1)}));
  const auto refused = stream.read_up_to(2);
  EXPECT_EQ(refused.back().reject().reason(), "TOO_MANY_UPDATES");
  EXPECT_EQ(refused.back().reject().code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(api_.get(kScene).head().revision(), 1u);
}

TEST_F(UpdateStreamRpcTest, ABatchAboveTheLimitOfBytesIsRejectedAndTheStreamContinues) {
  const std::uint64_t node = add_node();
  UpdateStream stream(api_);
  stream.open(kScene);
  const v1::Update large = patch({node}, 0, std::vector<accel::geometry::Vec3f>(300'000));
  for (std::size_t bytes = 0; bytes <= server::updates::kMaxBatchBytes;
       bytes += large.ByteSizeLong())
    ASSERT_TRUE(stream.send(1, {large}, true));
  ASSERT_TRUE(stream.send(1, {large}));
  ASSERT_TRUE(stream.send(2, {move_to(node, 3)}));
  const auto answers = stream.read_up_to(2);
  EXPECT_EQ(answers.front().reject().reason(), "BATCH_TOO_LARGE");
  EXPECT_EQ(x_of(api_, kScene, node), 3);
}

TEST_F(UpdateStreamRpcTest, AnUnfinishedBatchIsNotApplied) {
  {
    UpdateStream stream(api_);
    stream.open(kScene);
    stream.send(1, {put_node(-1)}, true);
    stream.close();
    EXPECT_TRUE(stream.finish().ok());
  }
  EXPECT_EQ(api_.get(kScene).nodes(), 0u);
  UpdateStream again(api_);
  EXPECT_EQ(again.open(kScene).last_committed(), 0u);
}

TEST_F(UpdateStreamRpcTest, ANewerCallTakesOver) {
  UpdateStream older(api_);
  older.open(kScene);
  older.send(1, {put_node(-1)});
  older.read_up_to(1);
  UpdateStream newer(api_), other(api_);
  EXPECT_EQ(newer.open(kScene).last_committed(), 1u);
  EXPECT_EQ(other.open(kScene, "another").last_committed(), 0u);
  const grpc::Status status = older.finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::ABORTED);
  EXPECT_EQ(reason_of(status), "PRODUCER_TAKEN_OVER");
  newer.send(2, {put_node(-1)});
  EXPECT_EQ(newer.read_up_to(2).back().ack().revision().revision(), 2u);
}

TEST_F(UpdateStreamRpcTest, ReportsTheIdsOfBatchesWhoseAcksWereNotRead) {
  {
    UpdateStream stream(api_);
    stream.open(kScene);
    for (std::uint64_t i = 1; i <= 20; ++i) {
      stream.send(i, {put_node(-1)});
      stream.read_up_to(i);
    }
  }
  UpdateStream again(api_);
  const v1::ProducerOpened opened = again.open(kScene);
  EXPECT_EQ(opened.last_committed(), 20u);
  ASSERT_EQ(opened.put_size(), 16);
  for (int i = 0; i < 16; ++i) {
    EXPECT_EQ(opened.put(i).sequence(), static_cast<std::uint64_t>(5 + i));
    EXPECT_EQ(opened.put(i).nodes(0), static_cast<std::uint64_t>(5 + i));
  }
}

TEST_F(UpdateStreamRpcTest, EndsWithItsScene) {
  UpdateStream stream(api_);
  stream.open(kScene);
  ASSERT_TRUE(api_.remove(kScene).ok());
  const grpc::Status status = stream.finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(reason_of(status), "SCENE_NOT_FOUND");
}

TEST_F(UpdateStreamRpcTest, ADrainingServerAnswersReceivedBatches) {
  UpdateStream stream(api_), idle(api_);
  stream.open(kScene);
  idle.open(kScene, "idle");
  stream.send(1, {put_node(-1)});
  stream.read_up_to(1);
  std::thread drain([&] { server_->drain(); });
  EXPECT_EQ(reason_of(stream.finish()), "STOPPING");
  EXPECT_EQ(idle.finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  drain.join();
}

TEST_F(UpdateStreamRpcTest, EveryBatchIsAppliedOnceThroughBrokenCalls) {
  constexpr std::uint64_t kBatches = 600;
  std::mt19937_64 random(7);
  std::uint64_t next = 1, calls = 0;
  while (next <= kBatches) {
    UpdateStream stream(api_);
    next = stream.open(kScene).last_committed() + 1;
    ++calls;
    const std::uint64_t stop = next + random() % 30;
    // Some answers are read, some batches are sent twice, and then the client disconnects.
    for (std::uint64_t i = next > 3 ? next - random() % 3 : next; i <= std::min(stop, kBatches);
         ++i)
      if (!stream.send(i, {put_node(-1), put_node(-2, "", -1)})) break;
    if (random() % 2 == 0 && next <= kBatches) {
      v1::StreamUpdatesResponse answer;
      stream.read(answer);
    }
    stream.cancel();
  }
  EXPECT_GT(calls, 20u);
  UpdateStream last(api_);
  EXPECT_EQ(last.open(kScene).last_committed(), kBatches);
  EXPECT_EQ(api_.get(kScene).nodes(), 2 * kBatches);
  EXPECT_EQ(api_.get(kScene).head().revision(), kBatches);
}

TEST_F(UpdateStreamRpcTest, CoalescesPosesAndKeepsTheLast) {
  constexpr std::uint64_t kPoses = 2000;
  const std::uint64_t node = add_node();
  UpdateStream stream(api_);
  stream.open(kScene, "poses", true);
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kPoses; ++i)
      ASSERT_TRUE(stream.send(i, {move_to(node, static_cast<double>(i))}));
    stream.close();
  });
  const auto answers = stream.read_up_to(kPoses);
  writer.join();
  EXPECT_TRUE(stream.finish().ok());
  const v1::UpdateAck& last = answers.back().ack();
  EXPECT_EQ(last.up_to_sequence(), kPoses);
  EXPECT_EQ(last.revision().revision(), 1 + kPoses - last.coalesced())
      << "each batch makes a revision, or is coalesced with a newer one";
  EXPECT_EQ(x_of(api_, kScene, node), kPoses);
}

TEST_F(UpdateStreamRpcTest, BlocksAProducerThatDoesNotRead) {
  const std::uint64_t node = add_node();
  UpdateStream stream(api_);
  stream.open(kScene);
  // Each ack is small: the connection buffers some thousands of them, and each waits for the one
  // before.
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= 100'000 && stream.send(i, {move_to(node, 1)}); ++i) {
    }
  });
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(api_.apply(kScene, {move_to(node, 2)}).ok());
  stream.cancel();
  writer.join();
  UpdateStream again(api_);
  const std::uint64_t committed = again.open(kScene).last_committed();
  EXPECT_EQ(api_.get(kScene).head().revision(), 51 + committed);
}

TEST_F(UpdateStreamRpcTest, ServesManyProducersConcurrently) {
  constexpr int kProducers = 8;
  constexpr std::uint64_t kBatches = 100;
  std::vector<std::thread> producers;
  for (int p = 0; p < kProducers; ++p) {
    producers.emplace_back([&, p] {
      Api api(connect(server_->port()));
      UpdateStream stream(api);
      stream.open(kScene, "producer-" + std::to_string(p), p % 2 == 0);
      for (std::uint64_t i = 1; i <= kBatches; ++i) EXPECT_TRUE(stream.send(i, {put_node(-1)}));
      stream.read_up_to(kBatches);
      stream.close();
      EXPECT_TRUE(stream.finish().ok());
    });
  }
  for (std::thread& producer : producers) producer.join();
  EXPECT_EQ(api_.get(kScene).nodes(), kProducers * kBatches);
  EXPECT_EQ(api_.get(kScene).head().revision(), kProducers * kBatches);
}

}  // namespace
}  // namespace sightline::tests

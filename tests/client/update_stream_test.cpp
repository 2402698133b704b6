// Streams of updates: in order and exactly once, through broken connections.
#include "client/update_stream.h"

#include <gtest/gtest.h>

#include <mutex>
#include <string>
#include <vector>

#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"
#include "tests/client/support/relay.h"
#include "tests/client/support/silent_port.h"

namespace sightline::client {
namespace {

using tests::kScene;

std::vector<Update> put(std::string name) {
  PutNode update;
  update.node = -1;
  update.name = std::move(name);
  return {update};
}

class UpdateStreamTest : public tests::LiveClient {
 protected:
  UpdateStreamTest() { EXPECT_TRUE(client_.create_scene(kScene)); }

  UpdateStream open(const Client& client, const UpdateStreamOptions& options = {}) {
    auto stream = client.open_update_stream(kScene, "producer", options);
    EXPECT_TRUE(stream) << stream.error().message;
    return *std::move(stream);
  }

  std::vector<std::string> names(std::size_t count) {
    std::vector<std::uint64_t> ids;
    for (std::uint64_t id = 1; id <= count; ++id) ids.push_back(id);
    std::vector<std::string> names;
    const auto nodes = client_.get_nodes(kScene, ids);
    EXPECT_TRUE(nodes) << nodes.error().message;
    for (const NodeInfo& node : *nodes) names.push_back(node.name);
    return names;
  }
};

Client connect(const std::string& endpoint, const ClientOptions& options = {}) {
  auto client = Client::connect(endpoint, options);
  EXPECT_TRUE(client);
  return *std::move(client);
}

TEST_F(UpdateStreamTest, BatchesAreAppliedInOrderOneRevisionEach) {
  UpdateStream stream = open(client_);
  for (std::uint64_t k = 1; k <= 40; ++k) {
    const auto sent = stream.send(put("node " + std::to_string(k)));
    ASSERT_TRUE(sent) << sent.error().message;
    EXPECT_EQ(*sent, k);
  }
  ASSERT_TRUE(stream.flush());
  EXPECT_EQ(stream.state().last_answered, 40U);
  EXPECT_EQ(stream.state().revision, 40U);
  EXPECT_FALSE(stream.state().token.empty());
  ASSERT_TRUE(stream.close());
  const auto names_now = names(40);
  for (std::size_t k = 0; k < 40; ++k) EXPECT_EQ(names_now[k], "node " + std::to_string(k + 1));
  EXPECT_EQ(stream.send(put("late")).error().code, Code::kFailedPrecondition);
}

TEST_F(UpdateStreamTest, ReportsAnswers) {
  std::vector<StreamAck> acks;
  std::vector<StreamReject> rejects;
  UpdateStreamOptions options;
  options.on_ack = [&](const StreamAck& ack) { acks.push_back(ack); };
  options.on_reject = [&](const StreamReject& reject) { rejects.push_back(reject); };
  UpdateStream stream = open(client_, options);
  ASSERT_TRUE(stream.send(put("a")));
  ASSERT_TRUE(stream.send(std::vector<Update>{DeleteNode{77, false}}));
  ASSERT_TRUE(stream.send(put("b")));
  EXPECT_TRUE(stream.wait(1));
  const Status refused = stream.wait(2);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kNotFound);
  EXPECT_NE(refused.error().message.find("77"), std::string::npos);
  EXPECT_TRUE(stream.wait(3));
  ASSERT_TRUE(stream.close()) << "a reject does not end the stream";
  ASSERT_EQ(rejects.size(), 1U);
  EXPECT_EQ(rejects[0].sequence, 2U);
  std::vector<std::uint64_t> ids;
  for (const StreamAck& ack : acks) {
    for (const StreamAck::Put& each : ack.put)
      ids.insert(ids.end(), each.nodes.begin(), each.nodes.end());
  }
  EXPECT_EQ(ids, (std::vector<std::uint64_t>{1, 2}));
  EXPECT_EQ(acks.back().up_to_sequence, 3U);
  EXPECT_EQ(acks.back().revision, 2U);
  EXPECT_EQ(stream.state().rejected, 1U);
}

TEST_F(UpdateStreamTest, ARejectIsAnAnswer) {
  UpdateStream stream = open(client_);
  ASSERT_TRUE(stream.send(std::vector<Update>{DeleteNode{77, false}}));
  ASSERT_TRUE(stream.flush());
  EXPECT_EQ(stream.wait(1).error().code, Code::kNotFound);
  EXPECT_TRUE(stream.close());
}

TEST_F(UpdateStreamTest, ANewStreamOfTheProducerContinuesWhereTheLastEnded) {
  {
    UpdateStream first = open(client_);
    for (int k = 0; k < 3; ++k) ASSERT_TRUE(first.send(put("x")));
    ASSERT_TRUE(first.close());
  }
  UpdateStream second = open(client_);
  EXPECT_EQ(second.state().last_sent, 3U);
  EXPECT_EQ(*second.send(put("y")), 4U);
  EXPECT_TRUE(second.close());
  EXPECT_EQ(client_.get_scene(kScene)->revision, 4U);
}

TEST_F(UpdateStreamTest, ASecondStreamOfTheSameNameTakesOver) {
  UpdateStream first = open(client_);
  ASSERT_TRUE(first.send(put("a")));
  ASSERT_TRUE(first.flush());
  UpdateStream second = open(client_);
  static_cast<void>(first.send(put("b")));  // The first stream may not have been notified yet
  const Status closed = first.close();
  ASSERT_FALSE(closed);
  EXPECT_EQ(closed.error().code, Code::kAborted);
  EXPECT_EQ(first.send(put("b")).error().code, Code::kAborted);
  EXPECT_EQ(*second.send(put("c")), 2U);
  EXPECT_TRUE(second.close());
}

// One node for each batch, named by its number; a lost or repeated batch would show.
class BrokenConnections : public UpdateStreamTest,
                          public testing::WithParamInterface<std::pair<std::size_t, std::size_t>> {
};

TEST_P(BrokenConnections, EveryBatchIsAppliedOnce) {
  constexpr std::size_t kBatches = 300;
  tests::Relay relay(server_->port());
  relay.cut_each_after(GetParam().first, GetParam().second);
  const Client through = connect(relay.endpoint());
  std::vector<std::uint64_t> reported;
  UpdateStreamOptions options;
  options.on_ack = [&](const StreamAck& ack) {
    for (const StreamAck::Put& each : ack.put) {
      EXPECT_EQ(each.nodes, std::vector<std::uint64_t>{each.sequence});
      reported.push_back(each.sequence);
    }
  };
  UpdateStream stream = open(through, options);
  for (std::size_t k = 1; k <= kBatches; ++k) {
    const auto sent = stream.send(put(std::to_string(k) + std::string(500, '.')));
    ASSERT_TRUE(sent) << sent.error().message;
  }
  const Status closed = stream.close();
  ASSERT_TRUE(closed) << closed.error().message;
  EXPECT_GT(stream.state().reconnects, 3U);
  EXPECT_EQ(client_.get_scene(kScene)->revision, kBatches);
  EXPECT_EQ(client_.get_scene(kScene)->nodes, kBatches);
  const auto names_now = names(kBatches);
  for (std::size_t k = 0; k < kBatches; ++k) EXPECT_EQ(std::stoul(names_now[k]), k + 1);
  ASSERT_EQ(reported.size(), kBatches) << "the ids of every batch are reported once";
  for (std::size_t k = 0; k < kBatches; ++k) EXPECT_EQ(reported[k], k + 1);
}

INSTANTIATE_TEST_SUITE_P(Cuts, BrokenConnections,
                         testing::Values(std::pair{std::size_t{20'000}, std::size_t{0}},
                                         std::pair{std::size_t{41'111}, std::size_t{0}},
                                         std::pair{std::size_t{0}, std::size_t{1'500}},
                                         std::pair{std::size_t{0}, std::size_t{777}}));

TEST_F(UpdateStreamTest, AFullWindowRefusesUpdatesUntilAnswersArrive) {
  tests::Relay relay(server_->port());
  const Client through = connect(relay.endpoint());
  UpdateStream stream = open(through);
  relay.hold(true);
  const std::uint32_t window = stream.state().window;
  for (std::uint32_t k = 0; k < window; ++k) {
    const auto sent = stream.try_send(put("x"));
    ASSERT_TRUE(sent && *sent) << k;
  }
  const auto refused = stream.try_send(put("y"));
  ASSERT_TRUE(refused);
  EXPECT_FALSE(*refused);
  relay.hold(false);
  const auto sent = stream.send(put("z"));
  ASSERT_TRUE(sent);
  EXPECT_EQ(*sent, window + 1) << "a refused batch has no number";
  EXPECT_TRUE(stream.close());
  EXPECT_EQ(client_.get_scene(kScene)->nodes, window + 1);
}

TEST_F(UpdateStreamTest, CanBeAbandonedAtAnyTime) {
  tests::Relay relay(server_->port());
  const Client through = connect(relay.endpoint());
  auto stream = std::make_unique<UpdateStream>(open(through));
  relay.hold(true);
  ASSERT_TRUE(stream->send(put("x")));
  stream.reset();
  relay.hold(false);
}

TEST_F(UpdateStreamTest, AServerThatDoesNotReturnIsAnError) {
  UpdateStream stream = open(client_, {.attempts = 2});
  ASSERT_TRUE(stream.send(put("x")));
  ASSERT_TRUE(stream.flush());
  stop_server();
  static_cast<void>(stream.send(put("y")));
  const Status flushed = stream.flush();
  ASSERT_FALSE(flushed);
  EXPECT_EQ(flushed.error().code, Code::kUnavailable);
  EXPECT_EQ(stream.close().error().code, Code::kUnavailable);
}

TEST_F(UpdateStreamTest, ADeletedSceneEndsTheStream) {
  UpdateStream stream = open(client_);
  ASSERT_TRUE(stream.send(put("x")));
  ASSERT_TRUE(stream.flush());
  ASSERT_TRUE(client_.delete_scene(kScene));
  static_cast<void>(stream.send(put("y")));  // The stream may not have been notified yet
  const Status closed = stream.close();
  ASSERT_FALSE(closed);
  EXPECT_EQ(closed.error().code, Code::kNotFound);
}

TEST_F(UpdateStreamTest, AStreamThatCannotBeOpenedFailsAtOnce) {
  EXPECT_EQ(client_.open_update_stream("projects/default/scenes/none", "p").error().code,
            Code::kNotFound);
  EXPECT_EQ(client_.open_update_stream(kScene, "no name").error().code, Code::kInvalidArgument);
  const tests::SilentPort silent;
  const Client waits = connect(silent.endpoint(), {.timeout = std::chrono::milliseconds(100)});
  EXPECT_EQ(waits.open_update_stream(kScene, "p").error().code, Code::kDeadlineExceeded);
}

TEST_F(UpdateStreamTest, ABatchLargerThanAMessageIsOneRevision) {
  importer::ImportedScene scene;
  scene.meshes.push_back(tests::sheets(50'000));
  scene.nodes.push_back({.name = "sheets", .mesh = 0});
  const char* const name = "projects/default/scenes/large";
  ASSERT_TRUE(upload_scene(client_, name, scene, {}));
  PatchVertices patch{{1}, 0, scene.meshes[0].vertices};
  for (Vertex& v : patch.positions) v[2] -= 50'000;
  auto stream = client_.open_update_stream(name, "p");
  ASSERT_TRUE(stream);
  ASSERT_TRUE(stream->send(std::vector<Update>{patch}));
  ASSERT_TRUE(stream->wait(1));
  EXPECT_GT(stream->state().bytes_sent, patch.positions.size() * sizeof(Vertex));
  EXPECT_EQ(stream->state().revision, 2U);
  EXPECT_TRUE(stream->close());
  EXPECT_TRUE((*client_.get_nodes(name, std::vector<std::uint64_t>{1}))[0].patched);
  std::vector<double> t(1);
  const tests::DownwardRays ray(1, 1);
  ASSERT_TRUE(client_.cast(name, ray.columns(), {.t = t}));
  EXPECT_EQ(t[0], 6) << "the highest sheet is at -1 now";
}

TEST_F(UpdateStreamTest, TheNewestTransformWins) {
  ASSERT_TRUE(client_.apply(kScene, put("moved")));
  UpdateStream stream = open(client_, {.latest_wins = true});
  for (int k = 1; k <= 200; ++k) {
    SetTransforms set{{1}, {kIdentity}};
    set.parent_from_local[0][3] = k;
    ASSERT_TRUE(stream.send(std::vector<Update>{set}));
  }
  ASSERT_TRUE(stream.close());
  const UpdateStreamState state = stream.state();
  EXPECT_EQ(state.last_answered, 200U);
  EXPECT_EQ(state.revision + state.coalesced, 201U);
  EXPECT_EQ((*client_.get_nodes(kScene, std::vector<std::uint64_t>{1}))[0].parent_from_local[3],
            200);
}

}  // namespace
}  // namespace sightline::client

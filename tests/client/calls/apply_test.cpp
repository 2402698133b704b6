// Updates in one message, in several, and as stream batches.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "client/calls/apply.h"
#include "client/client.h"
#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"
#include "tests/client/support/relay.h"

namespace sightline::client::calls {
namespace {

TEST(UpdateBatch, ASmallBatchIsOneMessage) {
  auto messages = pack_batch(std::vector<Update>{DeleteNode{1, false}, DeleteNode{2, true}});
  ASSERT_TRUE(messages);
  ASSERT_EQ(messages->size(), 1U);
  set_sequence(9, *messages);
  EXPECT_EQ((*messages)[0].batch().sequence(), 9U);
  EXPECT_EQ((*messages)[0].batch().updates_size(), 2);
  EXPECT_FALSE((*messages)[0].batch().more());
}

TEST(UpdateBatch, AnEmptyBatchIsOneMessage) {
  const auto messages = pack_batch({});
  ASSERT_TRUE(messages);
  ASSERT_EQ(messages->size(), 1U);
  EXPECT_TRUE((*messages)[0].has_batch());
}

TEST(UpdateBatch, LargeArraysAreCutBelowTheMessageLimitInOrder) {
  PatchVertices patch{{3}, 100, {}};
  for (std::size_t i = 0; i < 300'000; ++i)
    patch.positions.push_back({static_cast<float>(i), 0, 0});
  SetTransforms set;
  for (NodeRef i = 1; i <= 30'000; ++i) {
    set.nodes.push_back(i);
    set.parent_from_local.push_back(kIdentity);
  }
  const auto messages = pack_batch(std::vector<Update>{patch, set});
  ASSERT_TRUE(messages);
  std::size_t vertices = 0, transforms = 0;
  for (std::size_t m = 0; m < messages->size(); ++m) {
    const v1::UpdateBatch& batch = (*messages)[m].batch();
    EXPECT_LE((*messages)[m].ByteSizeLong(), std::size_t{1} << 20);
    EXPECT_EQ(batch.more(), m + 1 < messages->size());
    for (const v1::Update& update : batch.updates()) {
      if (update.has_patch_vertices()) {
        EXPECT_EQ(update.patch_vertices().first(), 100 + vertices);
        vertices += update.patch_vertices().positions().size() / sizeof(Vertex);
      } else {
        EXPECT_EQ(update.set_transforms().nodes(0), static_cast<NodeRef>(transforms + 1));
        transforms += static_cast<std::size_t>(update.set_transforms().nodes_size());
      }
    }
  }
  EXPECT_EQ(vertices, 300'000U);
  EXPECT_EQ(transforms, 30'000U);
}

TEST(UpdateBatch, LimitsAreCheckedByTheClient) {
  const std::vector<Update> many(kMaxUpdatesPerBatch + 1, DeleteNode{1, false});
  EXPECT_EQ(pack_batch(many).error().code, Code::kResourceExhausted);
  PutNode long_name;
  long_name.name = std::string(std::size_t{2} << 20, 'x');
  EXPECT_EQ(pack_batch(std::vector<Update>{long_name}).error().code, Code::kResourceExhausted);
  PatchVertices patch{{3}, 0, std::vector<Vertex>(1'000'000)};
  const std::vector<Update> heavy(6, patch);
  const auto refused = pack_batch(heavy);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find(std::to_string(kMaxBatchBytes)), std::string::npos);
  EXPECT_EQ(pack_batch(std::vector<Update>{SetTransforms{{1, 2}, {kIdentity}}}).error().message,
            "update 0: 2 nodes but 1 transforms");
}

using tests::kScene;

class Apply : public tests::LiveClient {
 protected:
  Apply() { EXPECT_TRUE(client_.create_scene(kScene)); }
};

PutNode put(NodeRef node, NodeRef parent, std::string name) {
  PutNode update;
  update.node = node;
  update.parent = parent;
  update.name = std::move(name);
  return update;
}

TEST_F(Apply, OneBatchIsOneRevision) {
  const auto applied =
      client_.apply(kScene, std::vector<Update>{put(-1, 0, "a"), put(-2, -1, "b")});
  ASSERT_TRUE(applied) << applied.error().message;
  EXPECT_EQ(applied->revision, 1U);
  EXPECT_EQ(applied->nodes, (std::vector<std::uint64_t>{1, 2}));
  SetTransforms set{{2}, {kIdentity}};
  set.parent_from_local[0][3] = 7;
  ASSERT_TRUE(client_.apply(kScene, std::vector<Update>{set}));
  EXPECT_EQ((*client_.get_nodes(kScene, applied->nodes))[1].parent_from_local[3], 7);
  ASSERT_FALSE(client_.apply(kScene, std::vector<Update>{DeleteNode{1, false}}));
  const auto deleted = client_.apply(kScene, std::vector<Update>{DeleteNode{1, true}});
  ASSERT_TRUE(deleted) << deleted.error().message;
  EXPECT_EQ(deleted->revision, 3U);
}

TEST_F(Apply, ABadUpdateDoesNotChangeTheScene) {
  const auto applied =
      client_.apply(kScene, std::vector<Update>{put(-1, 0, "a"), put(-2, 99, "b")});
  ASSERT_FALSE(applied);
  EXPECT_EQ(applied.error().code, Code::kNotFound);
  EXPECT_EQ(client_.get_scene(kScene)->revision, 0U);
}

TEST_F(Apply, AnUnexpectedRevisionIsAConflict) {
  EXPECT_EQ(client_.apply(kScene, std::vector<Update>{put(-1, 0, "a")}, {.expected_revision = 5})
                .error()
                .code,
            Code::kAborted);
  EXPECT_TRUE(
      client_.apply(kScene, std::vector<Update>{put(-1, 0, "a")}, {.expected_revision = 0}));
}

TEST_F(Apply, ARepeatedRequestIsAppliedOnce) {
  const std::vector<Update> updates{put(-1, 0, "a")};
  const auto first = client_.apply(kScene, updates, {.request_id = "r"});
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_FALSE(first->replayed);
  const auto again = client_.apply(kScene, updates, {.request_id = "r"});
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_TRUE(again->replayed);
  EXPECT_EQ(again->revision, first->revision);
  EXPECT_EQ(again->token, first->token);
  EXPECT_EQ(again->nodes, first->nodes);
  EXPECT_FALSE(client_.apply(kScene, updates)->replayed)
      << "by default each request has its own id";
  EXPECT_EQ(client_.get_scene(kScene)->nodes, 2U);
}

TEST_F(Apply, RepeatedPartsAreAppliedOnce) {
  std::vector<Update> updates;
  for (int i = 0; i < 3000; ++i) updates.emplace_back(put(-1 - i, 0, std::string(1000, 'x')));
  for (int round = 0; round < 2; ++round) {
    const auto applied = client_.apply_in_batches(kScene, updates, {.request_id = "r"});
    ASSERT_TRUE(applied) << applied.error().message;
    EXPECT_EQ(applied->replayed, round == 1);
    EXPECT_EQ(client_.get_scene(kScene)->nodes, 3000U);
  }
}

TEST_F(Apply, VerticesArePatched) {
  const char* const name = "projects/default/scenes/row";
  ASSERT_TRUE(upload_scene(client_, name, tests::row_of_sheets(2), {}));
  const PatchVertices patch{{2}, 4, {{0, 0, 3}, {1, 0, 3}, {1, 1, 3}, {0, 1, 3}}};
  const auto applied = client_.apply(name, std::vector<Update>{patch});
  ASSERT_TRUE(applied) << applied.error().message;
  const tests::DownwardRays rays(2, 2);
  std::vector<double> t(2);
  ASSERT_TRUE(client_.cast(name, rays.columns(), {.t = t}));
  EXPECT_EQ(t, (std::vector<double>{2, 4})) << "the other node keeps the old mesh";
  PatchVertices beyond = patch;
  beyond.first = 5;
  EXPECT_EQ(client_.apply(name, std::vector<Update>{beyond}).error().code, Code::kInvalidArgument);
}

TEST_F(Apply, ARequestIsSentAgainAfterABrokenConnection) {
  tests::Relay relay(server_->port());
  const auto through = Client::connect(relay.endpoint());
  ASSERT_TRUE(through && through->get_scene(kScene));
  relay.cut();
  const auto applied = through->apply(kScene, std::vector<Update>{put(-1, 0, "a")});
  ASSERT_TRUE(applied) << applied.error().message;
  EXPECT_EQ(client_.get_scene(kScene)->nodes, 1U);
}

TEST_F(Apply, AnUpdateAboveTheMessageLimitIsRefusedByTheClient) {
  const std::vector<Update> updates(2000, put(-1, 0, std::string(1000, 'x')));
  const auto applied = client_.apply(kScene, updates);
  ASSERT_FALSE(applied);
  EXPECT_EQ(applied.error().code, Code::kResourceExhausted);
  EXPECT_NE(applied.error().message.find("1048576"), std::string::npos);
}

TEST_F(Apply, AliasesAreValidAcrossMessages) {
  std::vector<Update> updates;
  const int n = 3000;
  updates.reserve(n);
  for (int i = 0; i < n; ++i) {
    updates.emplace_back(put(-1 - i, i == 0 ? 0 : -1, std::string(1000, 'x')));
  }
  const auto applied = client_.apply_in_batches(kScene, updates, {.expected_revision = 0});
  ASSERT_TRUE(applied) << applied.error().message;
  EXPECT_GT(applied->revision, 2U);
  ASSERT_EQ(applied->nodes.size(), std::size_t{n});
  const auto last = client_.get_nodes(kScene, std::vector<std::uint64_t>{applied->nodes.back()});
  ASSERT_TRUE(last);
  EXPECT_EQ((*last)[0].parent, applied->nodes.front());
}

TEST_F(Apply, ManyTransformsAreSentInParts) {
  const std::size_t n = 20000;
  std::vector<Update> puts;
  SetTransforms set;
  for (std::size_t i = 0; i < n; ++i) {
    const NodeRef alias = -1 - static_cast<NodeRef>(i);
    puts.emplace_back(put(alias, 0, ""));
    set.nodes.push_back(alias);
    set.parent_from_local.push_back(kIdentity);
    set.parent_from_local.back()[3] = static_cast<double>(i);
  }
  puts.emplace_back(set);
  const auto applied = client_.apply_in_batches(kScene, puts);
  ASSERT_TRUE(applied) << applied.error().message;
  const auto last = client_.get_nodes(kScene, std::vector<std::uint64_t>{applied->nodes.back()});
  ASSERT_TRUE(last);
  EXPECT_EQ((*last)[0].parent_from_local[3], n - 1);
}

TEST_F(Apply, TransformsWithoutNodesAreRefused) {
  const auto applied =
      client_.apply(kScene, std::vector<Update>{SetTransforms{{1, 2}, {kIdentity}}});
  ASSERT_FALSE(applied);
  EXPECT_EQ(applied.error().message, "update 0: 2 nodes but 1 transforms");
}

}  // namespace

}  // namespace sightline::client::calls

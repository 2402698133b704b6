// Batches cut into messages.
#include "client/calls/update_batch.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sightline::client::calls {
namespace {

TEST(UpdateBatch, ASmallOneIsOneMessage) {
  auto messages = pack_batch(std::vector<Update>{DeleteNode{1, false}, DeleteNode{2, true}});
  ASSERT_TRUE(messages);
  ASSERT_EQ(messages->size(), 1U);
  set_sequence(9, *messages);
  EXPECT_EQ((*messages)[0].batch().sequence(), 9U);
  EXPECT_EQ((*messages)[0].batch().updates_size(), 2);
  EXPECT_FALSE((*messages)[0].batch().more());
}

TEST(UpdateBatch, AnEmptyOneIsAMessageToo) {
  const auto messages = pack_batch({});
  ASSERT_TRUE(messages);
  ASSERT_EQ(messages->size(), 1U);
  EXPECT_TRUE((*messages)[0].has_batch());
}

TEST(UpdateBatch, LargeArraysAreCutBelowAMessagesLimitAndKeepTheirPlaces) {
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

TEST(UpdateBatch, LimitsAreKeptAtHome) {
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

}  // namespace
}  // namespace sightline::client::calls

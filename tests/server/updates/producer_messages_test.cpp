// Answers to a producer: in order, and few.
#include "server/updates/producer_messages.h"

#include <gtest/gtest.h>

namespace sightline::server::updates {
namespace {

TEST(UpdateAnswers, MergesConsecutiveAcks) {
  UpdateAnswers answers;
  answers.ack({1, {7, 1}, 0}, {10, 11});
  answers.ack({2, {7, 2}, 3}, {});
  answers.ack({2, {7, 2}, 3, scenes::Durability::kRelaxed, 0}, {});
  answers.reject(3, Error{Code::kNotFound, "gone", "NODE_NOT_FOUND"});
  answers.ack({4, {7, 3}, 5}, {12});
  v1::StreamUpdatesResponse out;
  EXPECT_EQ(answers.pop(out), 2u);
  EXPECT_EQ(out.ack().up_to_sequence(), 2u);
  EXPECT_EQ(out.ack().revision().revision(), 2u);
  EXPECT_EQ(out.ack().coalesced(), 3u);
  ASSERT_EQ(out.ack().put_size(), 1);
  EXPECT_EQ(out.ack().put(0).sequence(), 1u);
  EXPECT_EQ(out.ack().put(0).nodes_size(), 2);
  EXPECT_EQ(answers.pop(out), 1u);
  EXPECT_EQ(out.reject().sequence(), 3u);
  EXPECT_EQ(out.reject().code(), 5);
  EXPECT_EQ(out.reject().reason(), "NODE_NOT_FOUND");
  EXPECT_EQ(out.reject().message(), "gone");
  EXPECT_EQ(answers.pop(out), 1u);
  EXPECT_EQ(out.ack().up_to_sequence(), 4u);
  EXPECT_TRUE(answers.empty());
}

TEST(UpdateAnswers, AreSmallMessages) {
  UpdateAnswers answers;
  const std::vector<scenegraph::model::NodeId> many(65536, ~scenegraph::model::NodeId{0});
  for (std::uint64_t i = 1; i <= 4; ++i) answers.ack({i, {7, i}, 0}, many);
  v1::StreamUpdatesResponse out;
  for (std::uint64_t i = 1; i <= 4; ++i) {
    EXPECT_EQ(answers.pop(out), 1u);
    EXPECT_EQ(out.ack().up_to_sequence(), i);
    EXPECT_LT(out.ByteSizeLong(), std::size_t{1} << 20);
  }
}

}  // namespace
}  // namespace sightline::server::updates

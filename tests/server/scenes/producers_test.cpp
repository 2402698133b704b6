// Producers by name, and their stored answers.
#include "server/scenes/producers.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline::server::scenes {
namespace {

TEST(Producers, AreFoundAgainAndBounded) {
  Producers producers(2);
  const auto a = producers.open("a");
  ASSERT_TRUE(a);
  (*a)->commit(5, {});
  ASSERT_TRUE(producers.open("b"));
  const auto c = producers.open("c");
  ASSERT_FALSE(c);
  EXPECT_EQ(c.error().code, Code::kResourceExhausted);
  EXPECT_EQ((*producers.open("a"))->last_committed, 5u);
}

TEST(Producers, KeepTheIdsOfTheLastBatches) {
  Producer producer;
  for (std::uint64_t i = 1; i <= 40; ++i)
    producer.commit(i, i % 2 == 0 ? std::vector<scenegraph::model::NodeId>{i}
                                  : std::vector<scenegraph::model::NodeId>{});
  ASSERT_EQ(producer.put.size(), kPutsKept);
  EXPECT_EQ(producer.put.oldest().sequence, 25u);
  EXPECT_EQ(producer.put.newest().nodes.front(), 40u);
  producer.commit(41, std::vector<scenegraph::model::NodeId>(kPutIdsKept));
  EXPECT_EQ(producer.put.size(), 1u);
}

TEST(Producers, AreNamedInLettersDigitsDotsUnderscoresAndDashes) {
  for (const char* good : {"a", "Robot-1_arm.left", "0"}) EXPECT_TRUE(check_producer_name(good));
  for (const std::string& bad : {std::string(), std::string("a b"), std::string("a/b"),
                                 std::string(kMaxProducerName + 1, 'a')}) {
    EXPECT_EQ(check_producer_name(bad).error().reason, "BAD_PRODUCER") << bad;
  }
}

}  // namespace
}  // namespace sightline::server::scenes

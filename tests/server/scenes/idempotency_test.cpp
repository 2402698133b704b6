// Answers and producers that are kept, and for how long.
#include "server/scenes/idempotency.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline::server::scenes {
namespace {

TEST(RequestAnswers, KeepsTheLast) {
  exec::MemoryAccount memory(1 << 20);
  RequestAnswers answers(memory, {.answers = 3});
  for (std::uint64_t i = 1; i <= 5; ++i) {
    const std::string id = std::to_string(i);
    ASSERT_FALSE(*answers.find(id, i));
    answers.retain(answers.prepare(id, i, {.revision = i, .nodes = {10 * i}}));
  }
  EXPECT_FALSE(*answers.find("2", 2));
  for (std::uint64_t i = 3; i <= 5; ++i) {
    const auto found = answers.find(std::to_string(i), i);
    ASSERT_TRUE(found);
    ASSERT_TRUE(*found);
    EXPECT_EQ((*found)->revision, i);
    EXPECT_EQ((*found)->nodes.front(), 10 * i);
  }
}

TEST(RequestAnswers, KeepsFewerOfManyNodes) {
  exec::MemoryAccount memory(1 << 20);
  RequestAnswers answers(memory, {.answers = 10, .nodes = 100});
  for (std::uint64_t i = 1; i <= 4; ++i)
    answers.retain(
        answers.prepare(std::to_string(i), i,
                        {.revision = i, .nodes = std::vector<scenegraph::model::NodeId>(40)}));
  EXPECT_FALSE(*answers.find("2", 2));
  EXPECT_TRUE(*answers.find("3", 3));
  answers.retain(answers.prepare(
      "5", 5, {.revision = 5, .nodes = std::vector<scenegraph::model::NodeId>(1000)}));
  EXPECT_FALSE(*answers.find("4", 4));
  EXPECT_TRUE(*answers.find("5", 5));
  EXPECT_GE(memory.used(exec::Held::kLogs), 1000 * sizeof(scenegraph::model::NodeId));
  EXPECT_LT(memory.used(exec::Held::kLogs), 1100 * sizeof(scenegraph::model::NodeId))
      << "what is not kept is not charged";
}

TEST(RequestAnswers, RefusesADifferentRequestWithTheSameId) {
  exec::MemoryAccount memory(1 << 20);
  RequestAnswers answers(memory);
  answers.retain(answers.prepare("a", 1, {.revision = 7, .nodes = {}}));
  const auto other = answers.find("a", 2);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, Code::kInvalidArgument);
  EXPECT_NE(other.error().message.find("revision 7"), std::string::npos);
  EXPECT_TRUE((*answers.find("a", 1))->nodes.empty());
}

TEST(Producers, AreFoundAgainAndBounded) {
  exec::MemoryAccount memory(1 << 20);
  Producers producers(memory, 2);
  const auto a = producers.open("a");
  ASSERT_TRUE(a);
  (*a)->commit({.sequence = 5, .nodes = {}, .charge = {}});
  ASSERT_TRUE(producers.open("b"));
  const auto c = producers.open("c");
  ASSERT_FALSE(c);
  EXPECT_EQ(c.error().code, Code::kResourceExhausted);
  EXPECT_EQ((*producers.open("a"))->last_committed, 5u);
}

TEST(Producers, AreChargedByTheirNames) {
  exec::MemoryAccount memory(3 * kBytesPerProducer);
  Producers producers(memory);
  const std::string name(kMaxProducerName, 'x');
  ASSERT_TRUE(producers.open(name));
  EXPECT_EQ(memory.used(exec::Held::kLogs), kBytesPerProducer + 2 * name.size());
  ASSERT_TRUE(producers.open("b"));
  const auto third = producers.open("c");
  ASSERT_FALSE(third);
  EXPECT_EQ(third.error().reason, exec::kMemoryBudget);
  EXPECT_TRUE(producers.open(name)) << "it is known";
  const std::uint64_t before = memory.used();
  (*producers.open("b"))->put.reserve_more(kPutsKept);
  EXPECT_GE(memory.used(), before + kPutsKept * sizeof(Producer::Put));
}

TEST(Producers, KeepTheIdsOfTheLastBatches) {
  exec::MemoryAccount memory(1 << 20);
  Producer producer("robot", memory, {});
  for (std::uint64_t i = 1; i <= 40; ++i)
    producer.commit({i,
                     i % 2 == 0 ? std::vector<scenegraph::model::NodeId>{i}
                                : std::vector<scenegraph::model::NodeId>{},
                     {}});
  ASSERT_EQ(producer.put.size(), kPutsKept);
  EXPECT_EQ(producer.put.oldest().sequence, 25u);
  EXPECT_EQ(producer.put.newest().nodes.front(), 40u);
  producer.commit({41, std::vector<scenegraph::model::NodeId>(kPutIdsKept), {}});
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

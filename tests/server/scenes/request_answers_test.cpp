// Stored answers, and how long they are kept.
#include "server/scenes/request_answers.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline::server::scenes {
namespace {

TEST(RequestAnswers, KeepsTheLast) {
  RequestAnswers answers({.answers = 3});
  for (std::uint64_t i = 1; i <= 5; ++i) {
    const std::string id = "r" + std::to_string(i);
    ASSERT_EQ(*answers.find(id, i), nullptr);
    answers.retain(id, i, {.revision = i, .nodes = {10 * i}});
  }
  EXPECT_EQ(*answers.find("r2", 2), nullptr);
  for (std::uint64_t i = 3; i <= 5; ++i) {
    const auto found = answers.find("r" + std::to_string(i), i);
    ASSERT_TRUE(found);
    ASSERT_NE(*found, nullptr);
    EXPECT_EQ((*found)->revision, i);
    EXPECT_EQ((*found)->nodes.front(), 10 * i);
  }
}

TEST(RequestAnswers, KeepsFewerOfManyNodes) {
  RequestAnswers answers({.answers = 10, .nodes = 100});
  for (std::uint64_t i = 1; i <= 4; ++i)
    answers.retain(std::to_string(i), i,
                   {.revision = i, .nodes = std::vector<scenegraph::model::NodeId>(40)});
  EXPECT_EQ(*answers.find("2", 2), nullptr);
  EXPECT_NE(*answers.find("3", 3), nullptr);
  answers.retain("5", 5, {.revision = 5, .nodes = std::vector<scenegraph::model::NodeId>(1000)});
  EXPECT_EQ(*answers.find("4", 4), nullptr);
  EXPECT_NE(*answers.find("5", 5), nullptr);
}

TEST(RequestAnswers, RefusesADifferentRequestWithTheSameId) {
  RequestAnswers answers;
  answers.retain("a", 1, {.revision = 7, .nodes = {}});
  const auto other = answers.find("a", 2);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, Code::kInvalidArgument);
  EXPECT_NE(other.error().message.find("revision 7"), std::string::npos);
}

}  // namespace
}  // namespace sightline::server::scenes

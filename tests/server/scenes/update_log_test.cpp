// The updates that are kept.
#include "server/scenes/update_log.h"

#include <gtest/gtest.h>

namespace sightline::server::scenes {
namespace {

using scenegraph::model::PatchVertices;
using scenegraph::model::Update;

std::vector<Update> patch(std::size_t vertices) {
  return {PatchVertices{{1}, 0, std::vector<accel::geometry::Vec3f>(vertices)}};
}

TEST(UpdateLog, KeepsALimitedNumber) {
  UpdateLog log({.revisions = 3});
  EXPECT_EQ(log.last(), 0u);
  EXPECT_FALSE(log.find(0));
  EXPECT_FALSE(log.find(1));
  for (std::size_t i = 1; i <= 5; ++i)
    log.add(std::vector<Update>(i, scenegraph::model::DeleteNode{1}));
  EXPECT_EQ(log.last(), 5u);
  for (std::size_t i = 3; i <= 5; ++i) EXPECT_EQ((*log.find(i))->size(), i);
  for (const std::uint64_t outside : {0u, 2u, 6u}) {
    const auto found = log.find(outside);
    ASSERT_FALSE(found) << outside;
    EXPECT_EQ(found.error().code, Code::kOutOfRange);
    EXPECT_NE(found.error().message.find("3 to 5"), std::string::npos);
  }
}

TEST(UpdateLog, KeepsALimitedNumberOfBytesAndAlwaysTheLastEntry) {
  UpdateLog log({.revisions = 100, .bytes = 3 * bytes_of(patch(1000))});
  for (int i = 0; i < 5; ++i) log.add(patch(1000));
  EXPECT_FALSE(log.find(2));
  EXPECT_TRUE(log.find(3));
  log.add(patch(10'000));
  EXPECT_FALSE(log.find(5));
  EXPECT_TRUE(log.find(6));
}

TEST(UpdateLog, AHeldEntryOutlivesTheLog) {
  UpdateLog log({.revisions = 1});
  log.add(patch(7));
  const auto held = log.find(1);
  log.add({});
  EXPECT_FALSE(log.find(1));
  EXPECT_EQ(std::get<PatchVertices>((*held)->front()).positions.size(), 7u);
}

}  // namespace
}  // namespace sightline::server::scenes

// The revisions that are kept.
#include "server/scenes/recent_revisions.h"

#include <gtest/gtest.h>

namespace sightline::server::scenes {
namespace {

std::shared_ptr<const scenegraph::revision::Snapshot> revision(std::uint64_t number) {
  return std::make_shared<const scenegraph::revision::Snapshot>(number,
                                                                scenegraph::hierarchy::Hierarchy{});
}

TEST(RecentRevisions, KeepsALimitedNumber) {
  RecentRevisions recent({.revisions = 3});
  EXPECT_EQ(recent.oldest_or(7), 7u);
  for (std::uint64_t i = 0; i < 5; ++i) {
    EXPECT_EQ(recent.retain(revision(i)), nullptr);
    const auto dropped = recent.account(10);
    ASSERT_EQ(dropped.size(), i < 3 ? 0u : 1u);
    for (const auto& old : dropped) EXPECT_EQ(old->revision(), i - 3);
  }
  EXPECT_EQ(recent.find(1), nullptr);
  for (std::uint64_t i = 2; i < 5; ++i) EXPECT_EQ(recent.find(i)->revision(), i);
  EXPECT_EQ(recent.find(5), nullptr);
  EXPECT_EQ(recent.oldest_or(7), 2u);
}

TEST(RecentRevisions, KeepsALimitedNumberOfBytes) {
  RecentRevisions recent({.revisions = 100, .bytes = 100});
  const auto publish = [&](std::uint64_t number, std::uint64_t bytes) {
    EXPECT_EQ(recent.retain(revision(number)), nullptr);
    return recent.account(bytes).size();
  };
  EXPECT_EQ(publish(0, 60), 0u);
  EXPECT_EQ(publish(1, 40), 0u);
  EXPECT_EQ(publish(2, 1), 1u);
  EXPECT_EQ(publish(3, 60), 1u);
  EXPECT_EQ(recent.find(2)->revision(), 2u);
  EXPECT_EQ(publish(4, 1000), 3u) << "a revision that is too large by itself is not kept";
  EXPECT_EQ(publish(5, 100), 0u);
  EXPECT_EQ(recent.find(5)->revision(), 5u);
}

TEST(RecentRevisions, ReplacesTheSameRevision) {
  RecentRevisions recent;
  const auto first = revision(0), anew = revision(0);
  EXPECT_EQ(recent.retain(first), nullptr);
  EXPECT_EQ(recent.retain(anew), first);
  EXPECT_EQ(recent.find(0), anew);
}

TEST(RecentRevisions, DropsAll) {
  RecentRevisions recent;
  static_cast<void>(recent.retain(revision(0)));
  EXPECT_EQ(recent.drop_all().size(), 1u);
  EXPECT_EQ(recent.find(0), nullptr);
  EXPECT_TRUE(recent.account(5).empty());
  EXPECT_EQ(recent.retain(revision(1)), nullptr);
  EXPECT_EQ(recent.find(1)->revision(), 1u);
}

}  // namespace
}  // namespace sightline::server::scenes

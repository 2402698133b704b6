// Which entries a history keeps.
#include "server/scenes/history.h"

#include <gtest/gtest.h>

namespace sightline::server::scenes {
namespace {

TEST(History, DropsTheOldestBeyondTheNumber) {
  History<int> history({.entries = 2, .weight = 100});
  for (int i = 1; i <= 3; ++i) history.append(i);
  EXPECT_EQ(history.size(), 3u) << "append() drops nothing";
  EXPECT_EQ(history.trim(), std::vector<int>{1});
  EXPECT_EQ(history.oldest(), 2);
  EXPECT_EQ(history[1], 3);
  EXPECT_TRUE(history.trim().empty());
}

TEST(History, DropsTheOldestBeyondTheWeight) {
  History<int> history({.entries = 10, .weight = 100});
  history.append(1, 60);
  history.append(2, 40);
  EXPECT_TRUE(history.trim().empty());
  history.add_weight(1);
  EXPECT_EQ(history.trim(), std::vector<int>{1});
  history.append(3, 101);
  EXPECT_EQ(history.trim(), (std::vector<int>{2, 3}));
  EXPECT_TRUE(history.empty());
}

TEST(History, KeepsTheLeastNumberOfEntriesHoweverHeavy) {
  History<int> history({.entries = 10, .weight = 100, .min_entries = 1});
  history.append(1, 60);
  history.append(2, 1000);
  EXPECT_EQ(history.trim(), std::vector<int>{1});
  EXPECT_EQ(history.newest(), 2);
  history.append(3, 100);
  EXPECT_EQ(history.trim(), std::vector<int>{2});
  EXPECT_EQ(history.newest(), 3);
}

TEST(History, IsTrimmedToANumber) {
  History<int> history({.entries = 10, .weight = 100});
  history.append(1, 60);
  history.append(2, 40);
  EXPECT_TRUE(history.trim_to(2).empty());
  EXPECT_EQ(history.trim_to(1), std::vector<int>{1});
  EXPECT_EQ(history.trim_to(0), std::vector<int>{2});
  history.append(3, 100);
  EXPECT_TRUE(history.trim().empty());
}

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
    for (const auto& old : dropped) EXPECT_EQ(old.snapshot->revision(), i - 3);
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

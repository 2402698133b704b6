// The entries that a history keeps.
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

TEST(History, ClearReturnsAllAndResetsTheWeight) {
  History<int> history({.entries = 10, .weight = 100});
  history.append(1, 60);
  history.append(2, 40);
  EXPECT_EQ(history.clear(), (std::vector<int>{1, 2}));
  history.append(3, 100);
  EXPECT_TRUE(history.trim().empty());
}

}  // namespace
}  // namespace sightline::server::scenes

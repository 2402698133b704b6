// Words that may have been meant.
#include "client/cli/suggest.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sightline::client::cli {
namespace {

TEST(Suggest, DistanceCountsEdits) {
  EXPECT_EQ(edit_distance("", ""), 0U);
  EXPECT_EQ(edit_distance("cast", "cast"), 0U);
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("cats", "cast"), 1U);
  EXPECT_EQ(edit_distance("cst", "cast"), 1U);
  EXPECT_EQ(edit_distance("render", "fender"), 1U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
}

TEST(Suggest, TheNearestWordIsFoundIfItIsNear) {
  const std::vector<std::string> words{"cast", "scene", "stats", "stream", "prefetch"};
  EXPECT_EQ(nearest("cats", words), "cast");
  EXPECT_EQ(nearest("scen", words), "scene");
  EXPECT_EQ(nearest("pre", words), "prefetch");
  EXPECT_EQ(nearest("render", words), "");
  EXPECT_EQ(nearest("x", words), "");
  EXPECT_EQ(nearest("cast", {}), "");
}

}  // namespace
}  // namespace sightline::client::cli

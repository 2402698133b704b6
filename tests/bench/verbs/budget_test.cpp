// Trees within a budget: the figures of the verb, and that they keep within it.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/bench/verbs/verbs.h"

namespace sightline::bench {
namespace {

TEST(VerbBudget, KeepsWithinItsBudget) {
  CommonOptions common;
  common.scene = "gen:icosphere?level=6";
  common.threads = 2;
  const auto rows = run_budget(
      common, {.kinds = {"closeup", "random"}, .share = 0.25, .seconds = 0.5, .rays = 3000});
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  ASSERT_EQ(rows->size(), 2u);
  for (const Row& row : *rows) {
    EXPECT_EQ(row["triangles"], 81920);
    EXPECT_EQ(row["mismatches"], 0);
    EXPECT_GT(row["rays"], 0);
    EXPECT_GT(row["rays_per_s_unlimited"], 0);
    EXPECT_EQ(row["budget_bytes"], row["full_bytes"].get<std::uint64_t>() / 4);
    EXPECT_GT(row["most_bytes"], 0);
    // One expansion: the lists of the whole mesh.
    EXPECT_LT(row["over_bytes"], 2 * 81920 * 32);
  }
}

}  // namespace
}  // namespace sightline::bench

// clusters prints its documented keys, and both trees agree.
#include <gtest/gtest.h>

#include "tests/bench/verbs/verbs.h"
#include "tests/support/hard_clusters.h"

namespace sightline::bench {
namespace {

ClusterOptions small(std::string kind) {
  ClusterOptions options;
  options.kind = std::move(kind);
  options.triangles = 500;
  options.rays = 20;
  return options;
}

TEST(VerbClusters, HasARowForEveryKind) {
  const auto rows = run_clusters({}, small(""));
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  EXPECT_EQ((*rows)[0]["kind"], "compact");
  EXPECT_EQ((*rows)[0]["relative_work"], 1);
  EXPECT_GT(rows->size(), tests::clustered_meshes().size());
  for (const Row& row : *rows) {
    for (const char* key : {"kind", "builder", "triangles", "wrong", "final", "peak_full",
                            "peak_growing", "references_per_triangle", "touches_per_triangle",
                            "steps_per_ray", "tests_per_ray", "relative_work"}) {
      EXPECT_TRUE(row.contains(key)) << key << " in " << row.dump();
    }
    EXPECT_EQ(row["wrong"], 0) << row.dump();
    EXPECT_GE(row["peak_full"], row["final"]) << row.dump();
  }
}

TEST(VerbClusters, RefusesUnknownKinds) {
  const auto rows = run_clusters({}, small("torus"));
  ASSERT_FALSE(rows.ok());
  EXPECT_EQ(rows.error().code, Code::kInvalidArgument);
}

}  // namespace
}  // namespace sightline::bench

// stability prints its documented keys, and reports builders with known failures correctly.
#include <gtest/gtest.h>

#include <set>

#include "tests/bench/verbs/verbs.h"
#include "tests/support/hard_meshes.h"

namespace sightline::bench {
namespace {

CommonOptions common() {
  CommonOptions options;
  options.threads = 2;
  options.repeat = 1;
  return options;
}

StabilityOptions small(std::string family, std::vector<std::string> builders) {
  StabilityOptions options;
  options.family = std::move(family);
  options.triangles = 500;
  options.rays = 80;
  options.builders = std::move(builders);
  return options;
}

TEST(VerbStability, HasARowForEveryFamilyAndBuilder) {
  const auto rows = run_stability(common(), small("", {"scan-fast", "sah-naive"}));
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  ASSERT_EQ(rows->size(), 2 * tests::hard_meshes().size());
  for (const Row& row : *rows) {
    for (const char* key : {"family",
                            "rows",
                            "builder",
                            "triangles",
                            "ok",
                            "wrong",
                            "references_per_triangle",
                            "max_depth",
                            "given_up_cells",
                            "touches_per_triangle",
                            "relative_touches",
                            "bytes_peak_per_triangle",
                            "build_ms",
                            "relative_time",
                            "steps_per_ray",
                            "tests_per_ray",
                            "relative_work",
                            "sah_cost",
                            "failures",
                            "failed_by_design"}) {
      EXPECT_TRUE(row.contains(key)) << key << " in " << row.dump();
    }
    EXPECT_EQ(row["wrong"], 0) << row.dump();
  }
}

TEST(VerbStability, MeasuresWorkByTheExactSweep) {
  const auto rows = run_stability(common(), small("wall", {"spatial-median", "sah-sweep"}));
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  ASSERT_EQ(rows->size(), 2u);
  EXPECT_EQ((*rows)[0]["builder"], "sah-sweep");
  EXPECT_EQ((*rows)[0]["relative_work"], 1);
  EXPECT_GT((*rows)[1]["relative_work"].get<double>(), 1);
}

TEST(VerbStability, RefusesUnknownValues) {
  for (const StabilityOptions& options : {small("torus", {}), small("wall", {"magic"})}) {
    const auto rows = run_stability(common(), options);
    ASSERT_FALSE(rows.ok());
    EXPECT_EQ(rows.error().code, Code::kInvalidArgument);
  }
}

}  // namespace
}  // namespace sightline::bench

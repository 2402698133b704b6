// robust, answers and exactness print their documented keys and find the known faults.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <map>
#include <set>

#include "accel/published/any_builder.h"
#include "tests/bench/embree/peer.h"
#include "tests/bench/scenes/ray_orders.h"
#include "tests/bench/verbs/verbs.h"

namespace sightline::bench {
namespace {

CommonOptions common(std::string scene) {
  CommonOptions options;
  options.scene = std::move(scene);
  options.threads = 2;
  options.repeat = 1;
  return options;
}

void expect_keys(const Row& row, std::initializer_list<const char*> keys) {
  for (const char* key : keys) EXPECT_TRUE(row.contains(key)) << key << " in " << row.dump();
}

RobustOptions small(std::string family) {
  RobustOptions options;
  options.family = std::move(family);
  options.level = 3;
  options.count = 2000;
  return options;
}

TEST(VerbRobust, EveryBuilderLosesNothing) {
  for (const char* family : {"icosphere-0", "icosphere-1e7", "mesh-in-box"}) {
    RobustOptions options = small(family);
    for (const std::string_view name : accel::published::builder_names())
      options.builders.emplace_back(name);
    const auto rows = run_robust(common("gen:icosphere?level=2"), options);
    ASSERT_TRUE(rows.ok()) << rows.error().message;
    std::size_t exact = 0;
    for (const Row& row : *rows) {
      expect_keys(row, {"family", "kind", "builder", "policy", "method", "rays", "missed", "extra",
                        "checked", "mismatched", "mrays_per_s"});
      if (row["method"] != "exact") continue;
      ++exact;
      EXPECT_EQ(row["rays"], 500);
      EXPECT_EQ(row["missed"], 0) << row.dump();
      EXPECT_EQ(row["extra"], 0) << row.dump();
      EXPECT_EQ(row["mismatched"], 0) << row.dump();
      EXPECT_EQ(row["checked"], row["rays"]);
    }
    EXPECT_EQ(exact, 4 * (options.builders.size() + 1));
  }
}

TEST(VerbRobust, ShowsWhereFloatFails) {
  RobustOptions options = small("icosphere-0");
  options.builders = {"scan-fast"};
  const auto rows = run_robust(common(""), options);
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  std::map<std::string, std::uint64_t> faults;
  for (const Row& row : *rows) {
    faults[row["method"].get<std::string>()] +=
        row["missed"].get<std::uint64_t>() + row["extra"].get<std::uint64_t>();
  }
  EXPECT_EQ(faults.size(), embree_found() ? 4u : 2u);
  EXPECT_EQ(faults["exact"], 0u);
  EXPECT_GT(faults["plain-float"], 0u);
  if (embree_found()) {
    EXPECT_GT(faults["embree"], 0u);
  }
}

TEST(VerbRobust, RefusesUnknownValues) {
  const auto family = run_robust(common(""), small("torus"));
  ASSERT_FALSE(family.ok());
  EXPECT_EQ(family.error().code, Code::kInvalidArgument);
  RobustOptions options = small("icosphere-0");
  options.builders = {"magic"};
  EXPECT_FALSE(run_robust(common(""), options).ok());
}

TEST(VerbAnswers, AreAllTheSame) {
  const tbb::global_control parallelism(tbb::global_control::max_allowed_parallelism,
                                        kMostAnswerThreads);
  AnswersOptions options;
  options.count = 100;
  const auto rows = run_answers(common("gen:city?boxes=60"), options);
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  std::map<std::string, std::set<std::string>> seen;
  for (const Row& row : *rows) {
    for (const char* key : {"builder", "policy", "order", "simd", "closest", "any", "count", "all"})
      seen[key].insert(row[key].get<std::string>());
    for (const char* key : {"threads", "batch"}) seen[key].insert(row[key].dump());
  }
  EXPECT_EQ(seen["builder"].size(), accel::published::builder_names().size());
  EXPECT_EQ(seen["policy"], (std::set<std::string>{"demand", "first-touch", "full"}));
  EXPECT_EQ(seen["order"].size(), 5u);
  EXPECT_EQ(seen["threads"], (std::set<std::string>{"1", "2", "8"}));
  EXPECT_EQ(seen["batch"].size(), 4u);
  for (const char* kind : {"closest", "any", "count", "all"}) EXPECT_EQ(seen[kind].size(), 1u);
}

TEST(VerbAnswers, DifferForOtherRays) {
  const tbb::global_control parallelism(tbb::global_control::max_allowed_parallelism,
                                        kMostAnswerThreads);
  AnswersOptions options;
  options.count = 50;
  options.builders = {"scan-fast"};
  CommonOptions one = common("gen:city?boxes=60"), other = one;
  other.seed = 2;
  const auto a = run_answers(one, options), b = run_answers(other, options);
  ASSERT_TRUE(a.ok() && b.ok());
  for (const char* kind : {"closest", "count", "all"}) {
    EXPECT_NE(a->front()[kind], b->front()[kind]) << kind;
  }
}

TEST(VerbExactness, ChecksAnswersBeforeTimes) {
  ExactnessOptions options;
  options.count = 2000;
  const auto rows = run_exactness(common("gen:city?boxes=60"), options);
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  ASSERT_EQ(rows->size(), options.kinds.size());
  for (const Row& row : *rows) {
    expect_keys(row, {"scene", "rays", "count", "product_ms", "exact_ms", "plain_float_ms", "ratio",
                      "ratio_product", "hit_hash", "differences", "unexplained"});
    EXPECT_EQ(row["unexplained"], 0) << row.dump();
    EXPECT_GT(row["ratio"].get<double>(), 0);
  }
}

TEST(RayOrder, IsAPermutation) {
  std::vector<accel::geometry::Ray> rays(500);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    rays[i].origin.x = static_cast<double>(i * 7919 % 500);
  }
  std::set<std::vector<std::size_t>> orders;
  for (const std::string_view name : ray_order_names()) {
    const auto order = ray_order(name, rays);
    EXPECT_EQ(std::set<std::size_t>(order.begin(), order.end()).size(), rays.size()) << name;
    orders.insert(order);
  }
  EXPECT_EQ(orders.size(), ray_order_names().size());
}

}  // namespace
}  // namespace sightline::bench

// Regressions between two documents.
#include "client/load/check.h"

#include <gtest/gtest.h>

namespace sightline::client::load {
namespace {

using Json = nlohmann::ordered_json;

Json document(double rays_per_s, double p50_ms, double p99_ms, bool cold = false) {
  const Json row{{"build", cold ? "lazy" : "policy"},
                 {"coverage", 100.0},
                 {"cold", cold},
                 {"rays_per_s", rays_per_s},
                 {"p50_ms", p50_ms},
                 {"p99_ms", p99_ms},
                 {"failed", 0},
                 {"refused", 0}};
  return {{"scene", "s"}, {"kind", "closest"}, {"rays", "overview"}, {"batch", 8192},
          {"clients", 4}, {"rate", nullptr},   {"updates", 0.0},     {"rows", Json::array({row})}};
}

std::vector<std::string> figures(const Json& before, const Json& now, double tolerance = 0.1) {
  const auto found = find_regressions(before, now, tolerance);
  EXPECT_TRUE(found);
  std::vector<std::string> names;
  for (const Regression& regression : *found) names.push_back(regression.figure);
  return names;
}

using Names = std::vector<std::string>;

TEST(Check, TheSameAndTheFasterPass) {
  EXPECT_EQ(figures(document(1e6, 8, 20), document(1e6, 8, 20)), Names{});
  EXPECT_EQ(figures(document(1e6, 8, 20), document(2e6, 4, 10)), Names{});
  EXPECT_EQ(figures(document(1e6, 8, 20), document(0.95e6, 8.4, 25)), Names{});
}

TEST(Check, ATwentiethMoreThanToleratedIsFound) {
  EXPECT_EQ(figures(document(1e6, 8, 20), document(1e6 / 1.2, 8 * 1.2, 20 * 1.2)),
            (Names{"rays_per_s", "p50_ms"}));
  EXPECT_EQ(figures(document(1e6, 8, 20), document(1e6, 8, 27)), (Names{"p99_ms"}));
}

TEST(Check, OfColdRowsOnlyTheRateIsCompared) {
  EXPECT_EQ(figures(document(1e6, 8, 20, true), document(1e6, 80, 200, true)), Names{});
  EXPECT_EQ(figures(document(1e6, 8, 20, true), document(0.5e6, 8, 20, true)),
            (Names{"rays_per_s"}));
}

TEST(Check, RequestsThatFailAreARegression) {
  Json now = document(1e6, 8, 20);
  now["rows"][0]["refused"] = 3;
  EXPECT_EQ(figures(document(1e6, 8, 20), now), (Names{"refused"}));
}

TEST(Check, OnlyTimesAreWorthMeasuringAgain) {
  const auto row = [](const char* figure) { return Regression{"lazy at 10 %", figure, 1, 2}; };
  EXPECT_TRUE(may_be_noise({row("rays_per_s"), row("p99_ms")}));
  EXPECT_FALSE(may_be_noise({row("rays_per_s"), row("refused")}));
  EXPECT_FALSE(may_be_noise({row("failed")}));
}

TEST(Check, WhatIsNotComparableIsAnError) {
  Json other = document(1e6, 8, 20);
  other["batch"] = 1;
  const auto batch = find_regressions(other, document(1e6, 8, 20), 0.1);
  ASSERT_FALSE(batch);
  EXPECT_NE(batch.error().message.find("batch = 1, this one has 8192"), std::string::npos);
  EXPECT_FALSE(find_regressions(document(1e6, 8, 20, true), document(1e6, 8, 20), 0.1));
  EXPECT_FALSE(find_regressions(Json::array(), document(1e6, 8, 20), 0.1));
  EXPECT_FALSE(find_regressions(Json{{"scene", 1}}, document(1e6, 8, 20), 0.1));
}

TEST(Check, ARegressionIsALine) {
  EXPECT_EQ(to_string({"lazy at 10 %", "rays_per_s", 1e6, 5e5}),
            "lazy at 10 %: rays_per_s was 1e+06 and is 500000");
}

}  // namespace
}  // namespace sightline::client::load

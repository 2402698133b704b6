// The fit finds the coefficients that points were made from, and keeps them nonnegative.
#include "tests/bench/verbs/law_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace sightline::bench {
namespace {

std::vector<LawPoint> points_of(double a, double b, double wobble) {
  std::vector<LawPoint> points;
  double sign = 1;
  for (double n = 1024; n <= 65536; n *= 4) {
    for (double m = n / 256; m <= n; m *= 4) {
      points.push_back({n, m, (a * n + b * m * std::log2(m)) * (1 + sign * wobble)});
      sign = -sign;
    }
  }
  return points;
}

TEST(LawFit, FindsTheCoefficients) {
  const LawFit fit = fit_law(points_of(5, 3, 0));
  EXPECT_NEAR(fit.a, 5, 1e-9);
  EXPECT_NEAR(fit.b, 3, 1e-9);
  EXPECT_NEAR(fit.r_squared, 1, 1e-12);
  EXPECT_NEAR(fit.r_squared_log, 1, 1e-12);
  EXPECT_NEAR(fit.max_residual, 0, 1e-12);
  EXPECT_NEAR(fit.touches(1000, 8), 5 * 1000 + 3 * 8 * 3, 1e-9);
}

TEST(LawFit, ResidualsAreRelative) {
  const LawFit fit = fit_law(points_of(5, 3, 0.1));
  EXPECT_GT(fit.max_residual, 0.09);
  EXPECT_LT(fit.max_residual, 0.15);
  EXPECT_LT(fit.r_squared, 1);
  EXPECT_GT(fit.r_squared, 0.95);
  EXPECT_GT(fit.r_squared_log, 0.95);
}

TEST(LawFit, NeitherTermFallsBelowZero) {
  // Touches that fall as m grows: the second term can only increase the error.
  std::vector<LawPoint> falling;
  for (double m = 4; m <= 1024; m *= 4) falling.push_back({1024, m, 10000 - m});
  const LawFit a_alone = fit_law(falling);
  EXPECT_GT(a_alone.a, 0);
  EXPECT_EQ(a_alone.b, 0);
  // Only the second term, and less than that where n is large against m.
  std::vector<LawPoint> steep;
  for (double m = 4; m <= 1024; m *= 4) steep.push_back({1024, m, m * std::log2(m) * m / 1024});
  const LawFit b_alone = fit_law(steep);
  EXPECT_EQ(b_alone.a, 0);
  EXPECT_GT(b_alone.b, 0);
}

TEST(LawFit, OneTriangleSeenHasNoLogarithm) {
  const std::vector<LawPoint> points{{100, 1, 300}, {200, 1, 600}};
  const LawFit fit = fit_law(points);
  EXPECT_NEAR(fit.a, 3, 1e-12);
  EXPECT_EQ(fit.b, 0);
}

}  // namespace
}  // namespace sightline::bench

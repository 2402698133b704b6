// Buckets keep a relative error, from nanoseconds to hours.
#include "client/load/histogram.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sightline::client::load {
namespace {

constexpr double kRelativeError = 1.0 / (1 << (Histogram::kPrecisionBits + 1));

TEST(Histogram, OfNothingHasOnlyZeros) {
  const Histogram empty;
  EXPECT_EQ(empty.count(), 0u);
  EXPECT_EQ(empty.max(), 0u);
  EXPECT_EQ(empty.quantile(0.5), 0u);
  EXPECT_EQ(empty.mean(), 0);
}

TEST(Histogram, KnowsOneValueOfAnySizeWithinTheError) {
  for (std::uint64_t value = 1; value < 10'000'000'000'000u; value = value * 21 / 20 + 1) {
    Histogram histogram;
    histogram.add(value);
    histogram.add(value * 100);  // so that the maximum does not help
    const auto found = static_cast<double>(histogram.quantile(0.5));
    EXPECT_NEAR(found, static_cast<double>(value), static_cast<double>(value) * kRelativeError)
        << value;
  }
}

TEST(Histogram, SmallValuesAreExact) {
  Histogram histogram;
  for (std::uint64_t value = 0; value < 500; ++value) histogram.add(value);
  EXPECT_EQ(histogram.quantile(0.5), 249u);
  EXPECT_EQ(histogram.quantile(0), 0u);
  EXPECT_EQ(histogram.quantile(1), 499u);
  EXPECT_DOUBLE_EQ(histogram.mean(), 249.5);
}

TEST(Histogram, QuantilesAreThoseOfTheSortedValues) {
  Histogram histogram;
  for (std::uint64_t i = 1; i <= 1000; ++i) histogram.add(i * 1'000'000);
  for (const double share : {0.01, 0.5, 0.9, 0.99, 0.999}) {
    EXPECT_NEAR(static_cast<double>(histogram.quantile(share)), share * 1e9,
                share * 1e9 * kRelativeError);
  }
  EXPECT_EQ(histogram.max(), 1'000'000'000u);
  EXPECT_LE(histogram.quantile(1), histogram.max());
}

TEST(Histogram, SumsAreThoseOfAllValues) {
  Histogram all, first, second;
  for (std::uint64_t i = 0; i < 100; ++i) {
    all.add(i * i * 1000);
    (i % 2 == 0 ? first : second).add(i * i * 1000);
  }
  first.add(second);
  EXPECT_EQ(first.count(), all.count());
  EXPECT_EQ(first.max(), all.max());
  EXPECT_EQ(first.quantile(0.9), all.quantile(0.9));
  EXPECT_DOUBLE_EQ(first.mean(), all.mean());
}

}  // namespace
}  // namespace sightline::client::load

// Columns of rays, and batches of them.
#include "client/load/ray_set.h"

#include <gtest/gtest.h>

#include <type_traits>

namespace sightline::client::load {
namespace {

std::vector<Ray> some_rays(std::size_t count, bool with_interval) {
  std::vector<Ray> rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto x = static_cast<double>(i);
    rays[i].origin = {x, 1, 2};
    rays[i].direction = {0, x + 1, 0};
    if (with_interval) rays[i].tmax = x + 0.5;
  }
  return rays;
}

bool is_double(const RaySet& set) {
  return set.with(0, 0, [](const auto& columns) {
    return std::is_same_v<decltype(columns), const RayColumns<const double>&>;
  });
}

TEST(RaySet, GivesBackWhatWasPutInInBothPrecisions) {
  for (const auto precision : {RaySet::Precision::kFloat, RaySet::Precision::kDouble}) {
    const RaySet set = RaySet::of(some_rays(5, true), precision);
    EXPECT_EQ(is_double(set), precision == RaySet::Precision::kDouble);
    ASSERT_EQ(set.size(), 5u);
    EXPECT_EQ(set.at(3).origin[0], 3);
    EXPECT_EQ(set.at(3).direction[1], 4);
    EXPECT_EQ(set.at(3).tmin, 0);
    EXPECT_EQ(set.at(3).tmax, 3.5);
  }
}

TEST(RaySet, HasNoIntervalColumnsIfNoRayNeedsThem) {
  RaySet::of(some_rays(5, false), RaySet::Precision::kFloat).with(0, 5, [](const auto& columns) {
    EXPECT_TRUE(columns.tmin.empty());
    EXPECT_TRUE(columns.tmax.empty());
  });
}

TEST(RaySet, PicksRaysAndKeepsTheirColumns) {
  const RaySet set = RaySet::of(some_rays(9, true), RaySet::Precision::kDouble);
  const RaySet picked = set.pick(std::vector<std::size_t>{2, 7});
  EXPECT_TRUE(is_double(picked));
  ASSERT_EQ(picked.size(), 2u);
  EXPECT_EQ(picked.at(1).origin[0], 7);
  EXPECT_EQ(picked.at(1).tmax, 7.5);
}

TEST(RaySet, CopiesAndAppendsColumns) {
  const std::vector<float> origins{1, 2, 3}, directions{4, 5, 6};
  RaySet set = RaySet::copy<float>({origins, directions});
  set.append<float>({origins, directions});
  EXPECT_FALSE(is_double(set));
  ASSERT_EQ(set.size(), 2u);
  EXPECT_EQ(set.at(1).direction[2], 6);
}

TEST(Batches, GoRoundAndTheLastMayBeShort) {
  const RaySet set = RaySet::of(some_rays(10, false), RaySet::Precision::kFloat);
  const Batches batches(set, 4);
  EXPECT_EQ(batches.count(), 3u);
  const auto first_and_size = [&](std::uint64_t request) {
    return batches.with(request, [](const auto& rays) {
      return std::pair(static_cast<int>(rays.origins[0]), rays.size());
    });
  };
  EXPECT_EQ(first_and_size(0), std::pair(0, std::size_t{4}));
  EXPECT_EQ(first_and_size(2), std::pair(8, std::size_t{2}));
  EXPECT_EQ(first_and_size(4), std::pair(4, std::size_t{4}));
}

}  // namespace
}  // namespace sightline::client::load

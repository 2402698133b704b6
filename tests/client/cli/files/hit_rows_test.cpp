// Rows of a cast of all hits.
#include "client/cli/files/hit_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace sightline::client::cli::files {
namespace {

// Two hits, a miss, a bad ray, and one hit of a ray whose list was cut.
struct Answers {
  std::vector<std::uint32_t> offsets{0, 2, 2, 2, 3};
  std::vector<std::uint8_t> hit{1, 0, 2, kCutOff};
  std::vector<std::uint32_t> work{10, 11, 0, 13};
  std::vector<double> t{1, 2, 3};
  std::vector<std::uint64_t> node{4, 5, 6};
  std::vector<float> barycentric{0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F};

  HitView view() const {
    HitView hits;
    hits.offsets = offsets;
    hits.hit = hit;
    hits.work = work;
    hits.t = t;
    hits.node = node;
    hits.barycentric = barycentric;
    return hits;
  }
};

template <class T>
std::vector<T> copy(std::span<const T> rows) {
  return {rows.begin(), rows.end()};
}

TEST(HitRows, AreOneForEachHitAndOneForABadRay) {
  const Answers answers;
  HitRows rows;
  for (int twice = 0; twice < 2; ++twice) {
    const RowView view = rows.make(100, answers.view());
    ASSERT_EQ(rows.size(), 4U);
    EXPECT_EQ(copy(view.ray), (std::vector<std::uint64_t>{100, 100, 102, 103}));
    EXPECT_EQ(copy(view.node), (std::vector<std::uint64_t>{4, 5, 0, 6}));
    EXPECT_EQ(copy(view.hit), (std::vector<std::uint8_t>{1, 1, 2, 3}));
    EXPECT_EQ(copy(view.work), (std::vector<std::uint32_t>{10, 10, 0, 13}));
    EXPECT_EQ(view.t[1], 2);
    EXPECT_TRUE(std::isnan(view.t[2]));
    EXPECT_EQ(view.t[3], 3);
    EXPECT_EQ(view.barycentric[6], 0.5F);
  }
}

TEST(HitRows, HavePositionsAndNames) {
  const Answers answers;
  const std::vector<double> position{1, 2, 3, 4, 5, 6, 7, 8, 9};
  const std::vector<std::uint32_t> name{1, 0, 1};
  HitView hits = answers.view();
  hits.position = position;
  hits.name = name;
  hits.names = {"", "door"};
  HitRows rows;
  const RowView view = rows.make(0, hits);
  EXPECT_EQ(view.position[5], 6);
  EXPECT_TRUE(std::isnan(view.position[6])) << "the bad ray's";
  EXPECT_EQ(view.position[9], 7);
  EXPECT_EQ(name_of(view, 0), "door");
  EXPECT_EQ(name_of(view, 1), "");
  EXPECT_EQ(name_of(view, 2), "");
  EXPECT_EQ(name_of(view, 3), "door");
}

TEST(HitRows, AreCountedWithoutColumnT) {
  const Answers answers;
  HitView hits;
  hits.offsets = answers.offsets;
  hits.hit = answers.hit;
  HitRows rows;
  const RowView view = rows.make(0, hits);
  EXPECT_EQ(rows.size(), 4U);
  EXPECT_EQ(view.ray[3], 3U);
  EXPECT_EQ(view.hit[3], kCutOff);
}

}  // namespace
}  // namespace sightline::client::cli::files

// The intersector against exact arithmetic on 200,000 pairs of a ray and a triangle, where the ray
// narrowly passes or meets an edge. tests/fuzz/near_edge does the same for any number of pairs.
#include <gtest/gtest.h>

#include "accel/geometry/intersect.h"
#include "tests/fuzz/near_edges.h"
#include "tests/support/rounds.h"

namespace sightline::tests {
namespace {

constexpr std::size_t kPairs = rounds(200'000);

void expect_right(const Tally& tally) {
  const PairCount total = tally.total();
  EXPECT_EQ(total.wrong_hits, 0u);
  EXPECT_EQ(total.wrong_misses, 0u);
  EXPECT_EQ(total.wrong_t, 0u);
  EXPECT_EQ(total.wrong_weights, 0u);
  EXPECT_EQ(total.wrong_facing, 0u);
  EXPECT_EQ(total.wrong_sums, 0u);
  EXPECT_LE(tally.largest_t_error, accel::geometry::kHitError);
  for (const std::string& finding : tally.findings) ADD_FAILURE() << finding;
}

TEST(NearEdge, AgreesWithExactArithmetic) {
  const Tally tally = check_near_edges(kPairs, 1);
  expect_right(tally);
  // The cases are as hard as intended, and of every kind.
  const PairCount total = tally.total();
  EXPECT_GE(total.near, kPairs);
  for (const PairCount& count : tally.by_patch) {
    EXPECT_GT(count.near, count.pairs / 2);
    EXPECT_GT(count.hits, count.pairs / 10);
    EXPECT_GT(count.zeros, count.pairs / 10);
  }
  EXPECT_GT(total.one, kPairs / 20);
  EXPECT_GT(total.folded, kPairs / 20);
}

/// Seen nearly edge-on, through a vertex: that vertex has all the weight, not the other two.
TEST(NearEdge, WeightsHoldAtGrazingAngles) {
  HardCase hard;
  hard.connect(Patch::kTriangle);
  hard.origin = {0x1.8b459ep+115, 0x1.854d98p+116, 0x1.1a3b7ap+112};
  hard.direction = {-0x1.5f1ada0cbf982p+0, -0x1.e280de0af48c6p+0, -0x1.4da6f8ab89a87p+0};
  hard.vertex[0] = {-0x1.ce42ccp+114f, -0x1.48e42ep+113f, -0x1.17fe3ep+116f};
  hard.vertex[1] = {0x1.8b459ep+115f, 0x1.854d98p+116f, 0x1.1a3b7ap+112f};
  hard.vertex[2] = {0x1.f2b2e8p+116f, -0x1.8bf41ap+116f, -0x1.c2014cp+113f};
  Tally tally;
  check(hard, {.all_orders = true}, tally);
  expect_right(tally);
  EXPECT_EQ(tally.total().hits, 1u);
}

TEST(NearEdge, DoesNotDependOnTheOrderOfVertices) {
  expect_right(check_near_edges(kPairs / 10, 2, {.all_orders = true}));
}

TEST(NearEdge, DoesNotDependOnFlushedDenormalResults) {
  expect_right(check_near_edges(kPairs / 10, 3, {.flush_denormals = true}));
}

}  // namespace
}  // namespace sightline::tests

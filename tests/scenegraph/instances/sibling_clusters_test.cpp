// Clusters of siblings: each sibling once, in boxes that contain them; none where they do not help.
#include "scenegraph/instances/sibling_clusters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/random.h"

namespace sightline::scenegraph::instances {
namespace {

using accel::geometry::Aabb;
using accel::geometry::Vec3f;
using accel::kdtree::Reference;

/// Unit cells of a square, row by row.
std::vector<Reference> tiles(std::uint32_t side) {
  std::vector<Reference> refs;
  for (std::uint32_t i = 0; i < side * side; ++i) {
    const auto x = static_cast<float>(i % side), y = static_cast<float>(i / side);
    refs.push_back({{x, y, 0}, i, {x + 1, y + 1, 1}, 1 + i % 3});
  }
  return refs;
}

Aabb box_of(const std::vector<Reference>& refs) {
  Aabb box;
  for (const Reference& ref : refs) box.grow(ref.bounds());
  return box;
}

void shuffle(std::vector<Reference>& refs) {
  tests::Random random(3);
  for (std::size_t i = refs.size(); i > 1; --i) std::swap(refs[i - 1], refs[random.below(i)]);
}

/// Opens a cluster, checks it, and returns the number of its siblings.
std::size_t check(const Reference& ref, const std::vector<std::span<const Reference>>& members,
                  std::uint32_t first, std::vector<int>& met) {
  if (!ref.openable()) {
    ++met[ref.id];
    return 1;
  }
  EXPECT_NE(ref.id & kCluster, 0u);
  const std::uint32_t number = (ref.id & ~accel::kdtree::kOpenable & ~kCluster) - first;
  std::size_t count = 0;
  std::uint64_t weight = 0;
  EXPECT_LT(number, members.size());
  for (const Reference& member : members[number]) {
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_LE(ref.lo[a], member.lo[a]);
      EXPECT_GE(ref.hi[a], member.hi[a]);
    }
    weight += member.weight;
    count += check(member, members, first, met);
  }
  EXPECT_EQ(ref.weight, weight);
  return count;
}

std::size_t coarsest_of(std::vector<Reference> refs) {
  constexpr std::uint32_t kFirst = 1000;
  const Aabb box = box_of(refs);
  const std::size_t count = refs.size();
  std::vector<int> met(count);
  const SiblingClusters runs = make_clusters(std::move(refs), box, kFirst);
  const auto members = runs.members();
  EXPECT_LE(members.size(), max_clusters(count));
  std::size_t total = 0;
  for (const Reference& ref : runs.coarsest()) total += check(ref, members, kFirst, met);
  EXPECT_EQ(total, count);
  EXPECT_EQ(std::count(met.begin(), met.end(), 1), static_cast<std::ptrdiff_t>(count));
  return runs.coarsest().size();
}

TEST(SiblingClusters, LeaveFewSiblingsAsTheyAre) {
  EXPECT_EQ(coarsest_of({}), 0u);
  EXPECT_EQ(coarsest_of(tiles(1)), 1u);
  EXPECT_EQ(coarsest_of(tiles(8)), 64u);
  EXPECT_EQ(max_clusters(64), 0u);
}

TEST(SiblingClusters, GroupNeighbors) {
  EXPECT_EQ(coarsest_of(tiles(32)), 64u);
  EXPECT_EQ(coarsest_of(tiles(100)), 40u);
  EXPECT_EQ(max_clusters(10000), 625u + 40u);
}

TEST(SiblingClusters, GroupNeighborsInAnyOrder) {
  std::vector<Reference> refs = tiles(100);
  shuffle(refs);
  EXPECT_EQ(coarsest_of(refs), 40u);
}

TEST(SiblingClusters, AreNotMadeOfOverlappingSiblings) {
  tests::Random random(4);
  std::vector<Reference> refs;
  for (std::uint32_t i = 0; i < 5000; ++i) {
    const auto lo = static_cast<float>(random.uniform(0, 0.1));
    refs.push_back({{lo, lo, lo}, i, {lo + 1, lo + 1, lo + 1}, 1});
  }
  EXPECT_EQ(coarsest_of(refs), 5000u);
}

TEST(SiblingClusters, HandleBoxesWithoutExtent) {
  std::vector<Reference> same(1000);
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const Aabb box = accel::geometry::widen_flat({{2, 2, 2}, {2, 2, 2}});
    same[i] = {box.lo, i, box.hi, 1};
  }
  coarsest_of(same);
  std::vector<Reference> endless = tiles(32);
  endless[7].hi.x = INFINITY;
  coarsest_of(endless);
}

}  // namespace
}  // namespace sightline::scenegraph::instances

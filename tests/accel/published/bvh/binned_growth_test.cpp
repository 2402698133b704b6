// Binned hierarchies: what a split costs, what becomes a leaf, and the same for any threads.
#include "accel/published/bvh/binned_growth.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include <tbb/task_arena.h>

#include "accel/mesh/face_boxes.h"
#include "accel/published/bvh/bvh_builder.h"
#include "accel/published/bvh/bvh_measure.h"
#include "accel/published/bvh/center_bins.h"
#include "tests/accel/published/bvh/check_hierarchy.h"
#include "tests/support/scenes.h"

namespace sightline::accel::published::bvh {
namespace {

Bvh build(const tests::TestMesh& mesh, const BvhBuilder& builder = {}) {
  kdtree::BuildCounters counters;
  return builder.build(mesh.view(), counters);
}

std::vector<kdtree::Reference> references(const tests::TestMesh& mesh) {
  std::vector<kdtree::Reference> refs(mesh.faces.size());
  refs.resize(mesh::face_references(mesh.view(), 0, mesh.faces.size(), refs.data()));
  return refs;
}

/// The cost of every boundary of the bins, counted box by box.
double least_sum(const std::vector<kdtree::Reference>& refs, const CenterBins& bins,
                 std::uint32_t count) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::uint32_t last = 0; last + 1 < count; ++last) {
      geometry::Aabb left, right;
      double n_left = 0, n_right = 0;
      for (const kdtree::Reference& ref : refs) {
        const bool goes = bins.goes_left(ref, {.axis = axis, .last_left = last});
        (goes ? left : right).grow(ref.bounds());
        ++(goes ? n_left : n_right);
      }
      if (n_left == 0 || n_right == 0) continue;
      least = std::min(least, half_area(left) * n_left + half_area(right) * n_right);
    }
  }
  return least;
}

TEST(CenterBins, FindTheCheapestOfTheirBoundaries) {
  for (const std::uint32_t count : {2u, 3u, 16u, 256u}) {
    const std::vector<kdtree::Reference> refs = references(tests::random_soup(200, 0.1, count));
    ListSpan span;
    for (const kdtree::Reference& ref : refs) span.add(ref);
    CenterBins bins(span.centers, count);
    bins.add(refs);
    const BinSplit best = bins.best();
    ASSERT_TRUE(best.found);
    EXPECT_DOUBLE_EQ(best.sum, least_sum(refs, bins, count));
  }
}

TEST(CenterBins, OfPartsAddUp) {
  const std::vector<kdtree::Reference> refs = references(tests::random_soup(500, 0.1, 9));
  ListSpan span;
  for (const kdtree::Reference& ref : refs) span.add(ref);
  CenterBins whole(span.centers, 32), first(span.centers, 32), second(span.centers, 32);
  whole.add(refs);
  first.add(std::span(refs).first(123));
  second.add(std::span(refs).subspan(123));
  first += second;
  EXPECT_EQ(first.best().sum, whole.best().sum);
  EXPECT_EQ(first.best().axis, whole.best().axis);
  EXPECT_EQ(first.best().last_left, whole.best().last_left);
}

TEST(BinnedGrowth, LeavesAreAsLargeAsTheRuleSays) {
  const tests::TestMesh mesh = tests::icosphere(4);
  for (const std::uint32_t size : {1u, 4u, 8u}) {
    const Bvh bvh = build(mesh, {.leaf = {.leaf_size = size}});
    tests::check_hierarchy(bvh, mesh);
    for (const BvhNode& node : bvh.nodes) {
      for (const std::size_t side : {0u, 1u}) {
        if (!node.child(side).inner) {
          EXPECT_LE(node.child(side).count, size);
        }
      }
    }
    EXPECT_EQ(bvh.ids.size(), mesh.faces.size());
  }
}

TEST(BinnedGrowth, SplittingSmallListsPays) {
  const tests::TestMesh mesh = tests::icosphere(4);
  const kdtree::TreeMetrics paper = measure(build(mesh)),
                            further = measure(build(mesh, {.leaf = {.split_small = true}}));
  EXPECT_LT(further.sah_cost, paper.sah_cost);
}

TEST(BinnedGrowth, IsTheSameOnAnyNumberOfThreads) {
  const tests::TestMesh mesh = tests::random_soup(100'000, 0.01, 3);
  Bvh one;
  tbb::task_arena(1).execute([&] { one = build(mesh); });
  tbb::task_arena(4).execute([&] {
    const Bvh four = build(mesh);
    EXPECT_EQ(four.ids, one.ids);
    ASSERT_EQ(four.nodes.size(), one.nodes.size());
    for (std::size_t i = 0; i < one.nodes.size(); ++i) {
      ASSERT_EQ(four.nodes[i].bounds, one.nodes[i].bounds);
      ASSERT_EQ(four.nodes[i].first, one.nodes[i].first);
      ASSERT_EQ(four.nodes[i].count, one.nodes[i].count);
    }
  });
}

TEST(BinnedGrowth, CoincidentTrianglesAreHalved) {
  const tests::TestMesh mesh = tests::duplicates(1000);
  const Bvh bvh = build(mesh);
  tests::check_hierarchy(bvh, mesh);
  const kdtree::TreeMetrics m = measure(bvh);
  EXPECT_EQ(m.references, 1000u);
  EXPECT_LE(m.max_depth, 8);
}

TEST(BinnedGrowth, ShorterAndShorterSplitsEndAtTheDepthLimit) {
  // Each center lies beyond the last by the distance of all before it: a bin boundary separates
  // one.
  tests::TestMesh mesh;
  for (int i = 0; i < 250; ++i) {
    const auto x = static_cast<float>(std::ldexp(1.0, i - 125));
    const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {{x, 0, 0}, {x, 1, 0}, {x, 0, 1}});
    mesh.faces.push_back({n, n + 1, n + 2});
  }
  for (const std::uint32_t bins : {2u, 256u}) {
    const Bvh bvh = build(mesh, {.leaf = {.leaf_size = 1}, .bins = bins});
    tests::check_hierarchy(bvh, mesh);
    EXPECT_LE(measure(bvh).max_depth, kMaxBvhDepth);
  }
}

TEST(BinnedGrowth, HandlesTheEndsOfTheFloatRange) {
  tests::TestMesh mesh = tests::random_soup(50, 0.2, 4);
  for (const float scale : {3e38f, 1e-38f, 1e-44f}) {
    tests::TestMesh scaled = mesh;
    for (geometry::Vec3f& v : scaled.vertices) v = {v.x * scale, v.y * scale, v.z * scale};
    tests::check_hierarchy(build(scaled), scaled);
  }
}

TEST(BinnedGrowth, OfNoTrianglesIsAnEmptyLeaf) {
  const Bvh bvh = build({});
  EXPECT_FALSE(bvh.root.inner);
  EXPECT_EQ(bvh.root.count, 0u);
  EXPECT_EQ(measure(bvh).sah_cost, 0);
}

}  // namespace
}  // namespace sightline::accel::published::bvh

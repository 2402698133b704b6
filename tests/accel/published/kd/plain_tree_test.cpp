// Plain trees under rays: each is built once, by the first ray, and its figures are those of its
// cells.
#include "accel/published/kd/plain_tree.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include <tbb/parallel_for.h>

#include "accel/published/any_builder.h"
#include "tests/accel/published/kd/check_plain_tree.h"
#include "tests/support/scenes.h"

namespace sightline::accel::published::kd {
namespace {

PlainTree tree_over(const tests::TestMesh& mesh, const KdBuilder& builder) {
  return PlainTree(mesh.view(), mesh::compute_mesh_stats(mesh.view()), plain_rule(builder));
}

TEST(PlainTree, IsBuiltOnceByManyThreads) {
  const tests::TestMesh mesh = tests::icosphere(5);
  PlainTree tree = tree_over(mesh, HuntScan{});
  EXPECT_EQ(tree.built(), nullptr);
  EXPECT_EQ(tree.bytes(), 0u);
  EXPECT_EQ(tree.metrics().deferred_cells, 1u);
  std::vector<kdtree::BuildCounters> counters(4);
  std::vector<std::thread> threads;
  for (kdtree::BuildCounters& own : counters) threads.emplace_back([&] { tree.build(own); });
  for (std::thread& thread : threads) thread.join();
  kdtree::BuildCounters sum;
  for (const kdtree::BuildCounters& own : counters) sum += own;
  EXPECT_EQ(sum.cells_expanded, 1u);
  EXPECT_EQ(sum.trees_begun, 1u);
  EXPECT_EQ(sum.touches_prepare, mesh.faces.size());
  ASSERT_NE(tree.built(), nullptr);
  EXPECT_EQ(tree.bytes(), tree.built()->bytes());
}

// A building thread must not run another ray's task, which would wait for the same build.
TEST(PlainTree, IsBuiltFromWithinTasks) {
  const tests::TestMesh mesh = tests::random_soup(50'000, 0.02, 8);
  PlainTree tree = tree_over(mesh, ExactBuilder{});
  std::atomic<int> done = 0;
  tbb::parallel_for(0, 64, [&](int) {
    kdtree::BuildCounters counters;
    tree.build(counters);
    ++done;
  });
  EXPECT_EQ(done, 64);
}

TEST(PlainTree, MetricsAreThoseOfItsCells) {
  const tests::TestMesh mesh = tests::random_soup(2000, 0.05, 3);
  PlainTree tree = tree_over(mesh, HuntScan{});
  kdtree::BuildCounters counters;
  tree.build(counters);
  const kdtree::TreeMetrics metrics = tree.metrics();
  std::uint64_t references = 0, nonempty = 0;
  double expected_leaves = 0, expected_intersections = 0;
  const auto leaves = tests::leaves_of(*tree.built(), tree.bounds());
  for (const tests::PlainLeaf& leaf : leaves) {
    const double share = half_area(leaf.cell) / half_area(tree.bounds());
    references += leaf.ids.size();
    nonempty += leaf.ids.empty() ? 0 : 1;
    expected_leaves += share;
    expected_intersections += share * static_cast<double>(leaf.ids.size());
  }
  EXPECT_EQ(metrics.leaves, leaves.size());
  EXPECT_EQ(metrics.nodes, 2 * leaves.size() - 1);
  EXPECT_EQ(metrics.nodes, tree.cells());
  EXPECT_EQ(metrics.nonempty_leaves, nonempty);
  EXPECT_EQ(metrics.references, references);
  EXPECT_NEAR(metrics.expected_leaves, expected_leaves, 1e-9 * expected_leaves);
  EXPECT_NEAR(metrics.expected_intersections, expected_intersections,
              1e-9 * expected_intersections);
  EXPECT_EQ(metrics.sah_cost, metrics.expected_traversals + 1.5 * metrics.expected_intersections);
  EXPECT_EQ(metrics.deferred_cells, 0u);
  EXPECT_GT(metrics.max_depth, 8);
}

TEST(PlainTree, OfNothingIsALeaf) {
  const tests::TestMesh mesh;
  PlainTree tree = tree_over(mesh, HuntScan{});
  kdtree::BuildCounters counters;
  tree.build(counters);
  EXPECT_EQ(tree.metrics().nodes, 1u);
  EXPECT_EQ(tree.metrics().leaves, 1u);
  EXPECT_EQ(tree.metrics().references, 0u);
  EXPECT_EQ(tree.cells(), 1u);
}

}  // namespace
}  // namespace sightline::accel::published::kd

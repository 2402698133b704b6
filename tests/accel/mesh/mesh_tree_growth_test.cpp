// How a tree over a mesh grows: where rays go, to its end, cancelled, by several threads.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/tree_metrics.h"
#include "accel/lazy/growing_leaf.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/published/any_builder.h"
#include "tests/accel/mesh/asked_tree.h"
#include "tests/accel/wide/rule_over_mesh.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::accel::mesh {
namespace {

using tests::Answer;
using tests::ask;
using tests::make_tree;
using tests::query_of;
using tests::search;
using tests::TestMesh;

TEST(MeshTreeGrowth, GrowsOnlyWhereRaysGo) {
  const TestMesh mesh = tests::icosphere(5);  // 20,480 triangles
  const auto tree = make_tree(mesh);
  kdtree::WalkCounters walked;
  kdtree::BuildCounters first, again;
  std::vector<geometry::Ray> rays;
  tests::Random random(2);
  for (int i = 0; i < 500; ++i) {
    rays.push_back({{0, 0, 3},
                    geometry::Vec3d{random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), -1},
                    0,
                    2.5});
  }
  const kdtree::EpochPin pin;
  for (const geometry::Ray& ray : rays) {
    tests::MeshQuery query = query_of(ray);
    ask(*tree, query, walked, first);
  }
  EXPECT_GT(first.cells_expanded, 0u);
  EXPECT_GE(first.touches_prepare, mesh.faces.size());
  EXPECT_LT(first.touches_prepare, 2 * mesh.faces.size());
  const kdtree::GrowthMetrics growth = tree->growth();
  EXPECT_GT(growth.references_built, 0u);
  EXPECT_LT(growth.references_built, mesh.faces.size() / 5);
  for (const geometry::Ray& ray : rays) {
    tests::MeshQuery query = query_of(ray);
    ask(*tree, query, walked, again);
  }
  EXPECT_EQ(again.cells_expanded, 0u);
  EXPECT_EQ(again.touches, 0u);
}

/// A tree that is built at once, and one that rays begin.
struct FullAndLazy {
  FullAndLazy() : full(make_tree(mesh)), lazy(make_tree(mesh)) {
    kdtree::BuildCounters counters;
    full->expand_all(counters);
    for (const geometry::Ray& ray : rays) ask(*lazy, ray);
    lazy->expand_all(counters);
  }

  const TestMesh mesh = tests::random_soup(5000, 0.03, 3);
  const std::vector<geometry::Ray> rays = tests::rays_at(mesh, 50, 1);
  std::unique_ptr<MeshTree> full, lazy;
};

// The cells are the same; which of them share wide nodes depends on what was built at once.
TEST(MeshTreeGrowth, AFinishedLazyTreeHasTheBlocksOfTheFullTree) {
  const FullAndLazy trees;
  for (const geometry::Ray& ray : trees.rays)
    EXPECT_EQ(ask(*trees.full, ray), ask(*trees.lazy, ray));
  const kdtree::EpochPin pin;
  const kdtree::TreeMetrics a = trees.full->metrics(), b = trees.lazy->metrics();
  EXPECT_EQ(a.leaves, b.leaves);
  EXPECT_EQ(a.references, b.references);
  EXPECT_NEAR(a.expected_intersections, b.expected_intersections, 0.01 * a.expected_intersections);
  EXPECT_EQ(b.deferred_cells, 0u);
}

TEST(MeshTreeGrowth, TreesStayUsableAfterACancelledBuild) {
  const TestMesh mesh = tests::random_soup(20000, 0.02, 4);
  const auto tree = make_tree(mesh);
  const std::atomic<bool> cancelled{true};
  kdtree::BuildCounters counters;
  tree->expand_all(counters, &cancelled);
  {
    const kdtree::EpochPin pin;
    EXPECT_GT(tree->metrics().deferred_cells, 0u);
  }
  for (const geometry::Ray& ray : tests::rays_at(mesh, 20, 1))
    EXPECT_EQ(ask(*tree, ray), search(mesh, ray, tests::Question{}));
  tree->expand_all(counters);
  const kdtree::EpochPin pin;
  EXPECT_EQ(tree->metrics().deferred_cells, 0u);
}

/// How many triangles a cancelled ray tests that has `tree` searched.
std::uint64_t tests_when_cancelled(MeshTree& tree, const geometry::LocalRay& ray) {
  const kdtree::EpochPin pin;
  const std::atomic<bool> cancelled{true};
  tests::MeshQuery query;
  query.cells.growth = lazy::Growth::kNone;
  query.cells.cancelled = &cancelled;
  query.ray = ray;
  kdtree::WalkCounters walked;
  kdtree::BuildCounters built;
  ask(tree, query, walked, built);
  return walked.tests;
}

TEST(MeshTreeGrowth, ACancelledRayLeavesALongSearch) {
  // All triangles meet the ray, and none hides another.
  TestMesh mesh;
  constexpr std::uint32_t kTriangles = 50'000;
  for (std::uint32_t i = 0; i < kTriangles; ++i) {
    const float z = static_cast<float>(kTriangles - i);
    mesh.vertices.insert(mesh.vertices.end(), {{0, 0, z}, {1, 0, z}, {0, 1, z}});
    mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const auto tree = make_tree(mesh);
  const auto ray = geometry::make_local_ray({0.2, 0.2, -1}, {0, 0, 1});
  EXPECT_LE(tests_when_cancelled(*tree, *ray), lazy::kSearchStep) << "before the root has a list";
  // A ray across the first one expands some cells.
  ask(*tree, {.origin = {-1, 0.2, 25000.5}, .direction = {1, 0, 0}});
  EXPECT_LE(tests_when_cancelled(*tree, *ray), lazy::kSearchStep);
}

TEST(MeshTreeGrowth, ThreadsInOneColdTreeAgree) {
  // Large enough that the first cells are shared by threads and the later ones are raced for.
  const TestMesh mesh = tests::random_soup(60000, 0.01, 6);
  const std::vector<geometry::Ray> rays = tests::rays_at(mesh, 1500, 8);
  const auto reference = make_tree(mesh);
  kdtree::BuildCounters counters;
  reference->expand_all(counters);
  std::vector<Answer> expected;
  for (const geometry::Ray& ray : rays) expected.push_back(ask(*reference, ray));
  const auto tree = make_tree(mesh);
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&, i] {
      if (i == 7) {
        kdtree::BuildCounters own;
        tree->expand_all(own);
        return;
      }
      for (std::size_t k = 0; k < rays.size(); ++k) {
        const std::size_t at = (k + static_cast<std::size_t>(i) * 37) % rays.size();
        if (ask(*tree, rays[at]) != expected[at]) ++wrong;
      }
    });
  }
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(wrong, 0);
  const kdtree::EpochPin pin;
  EXPECT_EQ(tree->metrics().deferred_cells, 0u);
}

}  // namespace
}  // namespace sightline::accel::mesh

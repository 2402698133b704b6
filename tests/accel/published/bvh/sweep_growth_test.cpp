// Hierarchies grown by sweeping, with and without spatial splits: complete, bounded, and the same
// for any number of threads.
#include "accel/published/bvh/sweep_growth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "accel/published/bvh/bvh_measure.h"
#include "tests/accel/published/bvh/check_hierarchy.h"
#include "tests/accel/published/bvh/fragments.h"

namespace sightline::accel::published::bvh {
namespace {

using tests::TestMesh;

struct Grown {
  Bvh bvh;
  kdtree::BuildCounters counters;
  std::size_t references = 0;  ///< Number of references.
};

Grown grow(const TestMesh& mesh, const SpatialRule& spatial, const BvhLeafRule& leaf = {}) {
  const geometry::MeshView view = mesh.view();
  std::vector<kdtree::Reference> refs = tests::face_refs(mesh);
  Grown grown;
  grown.references = refs.size();
  BvhGrowth growth(sweep_capacity(refs.size(), spatial));
  grown.bvh =
      growth.finish(grow_by_sweep(&view, std::move(refs), leaf, spatial, growth, grown.counters));
  return grown;
}

constexpr SpatialRule kNever{.alpha = 1};

TEST(SpatialRule, NamesTheValueOutOfRange) {
  EXPECT_FALSE(SpatialRule{}.check());
  EXPECT_NE(SpatialRule{.alpha = -0.1}.check().value_or("").find("alpha"), std::string::npos);
  EXPECT_NE(SpatialRule{.alpha = 1.5}.check().value_or("").find("alpha"), std::string::npos);
  EXPECT_NE(SpatialRule{.node_overlap = 2}.check().value_or("").find("node_overlap"),
            std::string::npos);
  EXPECT_NE(SpatialRule{.bins = 1}.check().value_or("").find("spatial_bins"), std::string::npos);
  EXPECT_NE(SpatialRule{.bins = 257}.check().value_or("").find("256"), std::string::npos);
  EXPECT_NE(SpatialRule{.budget = -1}.check().value_or("").find("budget"), std::string::npos);
  EXPECT_TRUE(SpatialRule{.budget = std::nan("")}.check());
  EXPECT_EQ(SpatialRule{.budget = 0.5}.most_references(1001), 1501u);
  EXPECT_EQ(kNever.most_references(1001), 1001u);
  EXPECT_LT(SpatialRule{.budget = 63}.most_references(2'000'000'000u), std::size_t{1} << 31);
}

TEST(SweepGrowth, ListsEveryFaceOnceWithoutSpatialSplits) {
  for (const std::uint32_t n : {0u, 1u, 2u, 7u, 8u, 9u, 100u, 20'000u}) {
    const TestMesh mesh = tests::random_soup(n, 0.2, n);
    const Grown grown = grow(mesh, kNever);
    tests::check_hierarchy(grown.bvh, mesh);
    EXPECT_EQ(grown.bvh.ids.size(), n);
    EXPECT_EQ(measure(grown.bvh).leaves, grown.bvh.nodes.size() + 1);
  }
}

TEST(SweepGrowth, HandlesSmallSizesWithAnyRule) {
  for (std::uint32_t n = 0; n <= 40; ++n) {
    for (const TestMesh& mesh :
         {tests::random_soup(n, 0.8, n), tests::duplicates(n), tests::flat_walls(n)}) {
      for (const std::uint32_t leaf_size : {1u, 8u}) {
        for (const bool small : {false, true}) {
          const BvhLeafRule leaf{.leaf_size = leaf_size, .split_small = small};
          tests::check_hierarchy(grow(mesh, kNever, leaf).bvh, mesh);
          tests::check_hierarchy(grow(mesh, {.alpha = 0, .budget = 2}, leaf).bvh, mesh);
          tests::check_hierarchy(grow(mesh, {.alpha = 0, .unsplit = false, .budget = 63}, leaf).bvh,
                                 mesh);
        }
      }
    }
  }
}

TEST(SweepGrowth, SpatialSplitsCoverEveryTriangle) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    TestMesh mesh = tests::turned(tests::beams(7), 40);
    mesh.append(tests::random_soup(1000, 0.3, seed));
    const SpatialRule rule{.alpha = 0, .bins = seed % 2 == 0 ? 256u : 13u, .unsplit = seed > 2};
    const Grown grown = grow(mesh, rule);
    tests::check_hierarchy(grown.bvh, mesh, 30);
    EXPECT_GT(grown.bvh.ids.size(), mesh.faces.size());
  }
}

TEST(SweepGrowth, IsTheSameForAnyNumberOfThreads) {
  const tbb::global_control more(tbb::global_control::max_allowed_parallelism, 4);
  const TestMesh mesh = tests::turned(tests::beams(10), 30);
  for (const double budget : {3.0, 0.2}) {
    for (const double alpha : {1.0, 1e-5, 0.0}) {
      const SpatialRule rule{.alpha = alpha, .budget = budget};
      std::optional<Grown> first;
      for (const int threads : {1, 2, 4}) {
        Grown grown;
        tbb::task_arena(threads).execute([&] { grown = grow(mesh, rule); });
        if (!first) first = grown;
        ASSERT_EQ(grown.bvh.ids, first->bvh.ids);
        ASSERT_EQ(grown.counters.touches, first->counters.touches);
        ASSERT_EQ(grown.counters.touches_prepare, first->counters.touches_prepare);
        ASSERT_EQ(grown.bvh.nodes.size(), first->bvh.nodes.size());
        for (std::size_t i = 0; i < grown.bvh.nodes.size(); ++i) {
          for (const std::size_t side : {0u, 1u}) {
            const BvhChild a = grown.bvh.nodes[i].child(side), b = first->bvh.nodes[i].child(side);
            ASSERT_TRUE(a.box == b.box && a.first == b.first && a.count == b.count);
          }
        }
      }
    }
  }
}

TEST(SweepGrowth, IsTheSameForAnyOrderOfReferences) {
  const TestMesh mesh = tests::random_soup(5000, 0.1, 3);
  const geometry::MeshView view = mesh.view();
  std::vector<kdtree::Reference> refs = tests::face_refs(mesh);
  const Grown straight = grow(mesh, {});
  std::reverse(refs.begin(), refs.end());
  kdtree::BuildCounters counters;
  BvhGrowth growth(sweep_capacity(refs.size(), {}));
  const Bvh reversed = growth.finish(grow_by_sweep(&view, refs, {}, {}, growth, counters));
  EXPECT_EQ(reversed.ids, straight.bvh.ids);
}

TEST(SweepGrowth, SpatialSplitsLowerCostAndOverlapOfRotatedBeams) {
  for (const double degrees : {0.0, 20.0, 45.0}) {
    const TestMesh mesh = tests::turned(tests::beams(8), degrees);
    const kdtree::TreeMetrics sweep = measure(grow(mesh, kNever).bvh);
    const kdtree::TreeMetrics split = measure(grow(mesh, {}).bvh);
    EXPECT_LE(split.sah_cost, sweep.sah_cost * 1.01) << degrees;
    if (degrees > 0) {
      EXPECT_LT(split.overlap, sweep.overlap) << degrees;
      EXPECT_LT(split.sah_cost, 0.95 * sweep.sah_cost) << degrees;
    }
  }
}

TEST(SweepGrowth, LittleOverlapNeedsNoSpatialSplit) {
  const TestMesh mesh = tests::turned(tests::beams(7), 45);
  const Grown all = grow(mesh, {}), some = grow(mesh, {.node_overlap = 0.2});
  EXPECT_LT(some.counters.touches, all.counters.touches);
  EXPECT_LT(measure(some.bvh).sah_cost, 1.05 * measure(all.bvh).sah_cost);
  EXPECT_EQ(grow(mesh, {.node_overlap = 1}).bvh.ids, grow(mesh, kNever).bvh.ids);
}

TEST(SweepGrowth, AddsNoMoreReferencesThanTheBudget) {
  const TestMesh mesh = tests::turned(tests::beams(7), 45);
  const std::size_t free = grow(mesh, {.budget = 63}).bvh.ids.size();
  ASSERT_GT(free, mesh.faces.size() * 5 / 4);
  double cost = std::numeric_limits<double>::infinity();
  for (const double budget : {0.0, 0.01, 0.05, 0.1, 0.2}) {
    const SpatialRule rule{.budget = budget};
    const Grown grown = grow(mesh, rule);
    tests::check_hierarchy(grown.bvh, mesh);
    const std::size_t most = rule.most_references(mesh.faces.size());
    EXPECT_LE(grown.bvh.ids.size(), most);
    // All of it helps, except the rest that is too small for a split.
    EXPECT_GE(grown.bvh.ids.size() + 16, most);
    const double now = measure(grown.bvh).sah_cost;
    EXPECT_LT(now, cost * 1.001) << budget;
    cost = now;
  }
}

TEST(SweepGrowth, HalfTheReferencesGiveMoreThanHalfTheGain) {
  const TestMesh mesh = tests::turned(tests::beams(7), 45);
  const Grown all = grow(mesh, {.budget = 63});
  const double triangles = static_cast<double>(mesh.faces.size());
  const double added = static_cast<double>(all.bvh.ids.size()) - triangles;
  const Grown some = grow(mesh, {.budget = 0.5 * added / triangles});
  const double worst = measure(grow(mesh, kNever).bvh).sah_cost;
  const double best = measure(all.bvh).sah_cost;
  EXPECT_LT(measure(some.bvh).sah_cost, 0.4 * worst + 0.6 * best);
}

TEST(SweepGrowth, DuplicatesAreHalved) {
  const TestMesh mesh = tests::duplicates(100'000);
  for (const SpatialRule& rule : {kNever, SpatialRule{.alpha = 0}}) {
    const Grown grown = grow(mesh, rule);
    EXPECT_EQ(grown.bvh.ids.size(), mesh.faces.size());
    EXPECT_LE(measure(grown.bvh).max_depth, 14);
  }
}

/// Each is half as long as the one before: the farthest is split off, one at a time.
TEST(SweepGrowth, DepthIsBoundedForAnyInput) {
  TestMesh mesh;
  for (int i = 0; i < 2000; ++i) {
    const float x = std::ldexp(1.0f, 100 - i % 200) * (1 + static_cast<float>(i) * 1e-4f);
    const auto v = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {{x, x, 0}, {1.25f * x, x, 0}, {x, 1.5f * x, 0}});
    mesh.faces.push_back({v, v + 1, v + 2});
  }
  for (const SpatialRule& rule : {kNever, SpatialRule{.alpha = 0, .budget = 10}}) {
    const Grown grown = grow(mesh, rule, {.leaf_size = 1});
    tests::check_hierarchy(grown.bvh, mesh);
    EXPECT_LE(measure(grown.bvh).max_depth, kMaxBvhDepth);
  }
}

TEST(SweepGrowth, HandlesCoordinatesOfAnySize) {
  for (const float scale : {1e-44f, 1e-38f, 1e-20f, 1e10f, 1e30f, 1e38f}) {
    for (const float at : {0.0f, 1.0f}) {
      TestMesh mesh = tests::random_soup(500, 0.4, 11);
      for (geometry::Vec3f& v : mesh.vertices) v = (v + geometry::Vec3f{at, at, at}) * scale;
      for (const SpatialRule& rule : {kNever, SpatialRule{.alpha = 0, .budget = 5}}) {
        tests::check_hierarchy(grow(mesh, rule).bvh, mesh);
      }
    }
  }
}

TEST(SweepGrowth, HandlesFlatAndThinTriangles) {
  TestMesh fan;
  for (int i = 0; i < 500; ++i) {
    const auto v = static_cast<std::uint32_t>(fan.vertices.size());
    const float y = static_cast<float>(i) * 0.002f;
    fan.vertices.insert(fan.vertices.end(), {{0, 0, 0}, {1, y, y}, {1, y + 0.001f, y}});
    fan.faces.push_back({v, v + 1, v + 2});
  }
  TestMesh points;
  points.vertices = {{1, 2, 3}, {1, 2, 3}, {4, 5, 6}};
  for (int i = 0; i < 50; ++i) points.faces.push_back({0, 1, i % 2 == 0 ? 0u : 2u});
  for (const TestMesh& mesh : {fan, points, tests::planar_sheet(20), tests::flat_walls(100),
                               tests::turned(tests::planar_sheet(20), 45)}) {
    for (const bool unsplit : {false, true}) {
      const SpatialRule rule{.alpha = 0, .unsplit = unsplit, .budget = 4};
      const Grown grown = grow(mesh, rule);
      tests::check_hierarchy(grown.bvh, mesh);
      EXPECT_LE(grown.bvh.ids.size(), 5 * mesh.faces.size());
    }
  }
}

TEST(SweepGrowth, WithoutAMeshThereAreNoSpatialSplits) {
  const TestMesh mesh = tests::turned(tests::beams(5), 45);
  kdtree::BuildCounters counters;
  BvhGrowth growth(sweep_capacity(mesh.faces.size(), {}));
  const Bvh bvh =
      growth.finish(grow_by_sweep(nullptr, tests::face_refs(mesh), {}, {}, growth, counters));
  EXPECT_EQ(bvh.ids, grow(mesh, kNever).bvh.ids);
}

}  // namespace
}  // namespace sightline::accel::published::bvh

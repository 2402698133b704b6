// The rule of demand: cells are searched until that has cost as much as expanding them; hits are
// the same, and so are the trees of equal requests.
#include "accel/lazy/demand.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "accel/grow/subtrees.h"
#include "accel/lazy/demand_costs.h"
#include "tests/accel/stability/asked_tree.h"
#include "tests/support/hard_rays.h"
#include "tests/support/hard_shapes.h"

namespace sightline::accel::lazy {
namespace {

using geometry::Ray;
using lazy::Growth;
using tests::AskedTree;
using tests::TestMesh;

constexpr geometry::Aabb kUnitCube{{0, 0, 0}, {1, 1, 1}};

TEST(CellPassage, IsThePartsAlongTheRay) {
  const auto along_x = *geometry::make_local_ray({-3, 0.1, 0.9}, {1, 0, 0});
  const CellPassage parts = passage(along_x, kUnitCube);
  EXPECT_EQ(parts.front(), part_of({0, 0.1, 0.9}, kUnitCube));
  EXPECT_EQ(parts.back(), part_of({1, 0.1, 0.9}, kUnitCube));
  const auto from_inside = *geometry::make_local_ray({0.6, 0.6, 0.6}, {-1, -1, -1});
  EXPECT_EQ(passage(from_inside, kUnitCube).front(), part_of({0.6, 0.6, 0.6}, kUnitCube));
  EXPECT_EQ(passage(from_inside, kUnitCube).back(), 0);
}

TEST(CellPassage, HoldsPointsBeyondTheBoxInTheNextPart) {
  EXPECT_EQ(part_of({-5, -5, -5}, kUnitCube), 0);
  EXPECT_EQ(part_of({5, 5, 5}, kUnitCube), kParts * kParts * kParts - 1);
}

/// References evenly in the first layer of parts along x.
PartShares first_layer() {
  PartShares shares{};
  constexpr double kEach = 1.0 / (kParts * kParts);
  for (std::size_t i = 0; i < kParts * kParts; ++i) shares[i] = kEach;
  return shares;
}

std::vector<CellPassage> rays_along_x(std::size_t count, double width) {
  std::vector<CellPassage> passages;
  for (std::size_t i = 0; i < count; ++i) {
    const double y = width * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    for (std::size_t k = 0; k < count; ++k) {
      const double z = width * (static_cast<double>(k) + 0.5) / static_cast<double>(count);
      passages.push_back(passage(*geometry::make_local_ray({-1, y, z}, {1, 0, 0}), kUnitCube));
    }
  }
  return passages;
}

TEST(ShareReached, IsOneForManyRaysEverywhereAndSmallForRaysInACorner) {
  EXPECT_GT(share_reached(rays_along_x(16, 1), 10, first_layer(), 20), 0.9);
  EXPECT_LT(share_reached(rays_along_x(16, 0.2), 10, first_layer(), 20), 0.1);
  EXPECT_LT(share_reached(rays_along_x(4, 1), 0.1, first_layer(), 20), 0.2) << "few rays";
  EXPECT_EQ(share_reached({}, 1, first_layer(), 20), 0);
}

struct Subject {
  const char* name;
  TestMesh mesh;
};

std::vector<Subject> subjects() {
  return {{"sphere", tests::icosphere(5)},
          {"soup", tests::random_soup(9000, 0.03, 1)},
          {"slivers", tests::slivers(4000, 2)},
          {"non-finite", tests::with_nonfinite(4000, 3)}};
}

TEST(Demand, SearchesUntilThatHasCostAsMuchAsExpanding) {
  const TestMesh mesh = tests::icosphere(5);
  AskedTree tree(mesh, "scan-fast");
  const Ray ray{{3, 0.1, 0.2}, {-1, 0, 0}};
  for (std::uint64_t i = 1; i < kPathCost; ++i) tree.nearest(ray, Growth::kDemand);
  EXPECT_EQ(tree.built().touches + tree.built().touches_prepare, 0u);
  tree.nearest(ray, Growth::kDemand);
  EXPECT_GT(tree.built().touches + tree.built().touches_prepare, 0u);
}

/// How often the ray is searched for before anything is built.
std::uint64_t searches_before_building(AskedTree& tree, const Ray& ray) {
  std::uint64_t searches = 0;
  for (; searches < 10 * kDenseCost; ++searches) {
    tree.nearest(ray, Growth::kDemand);
    if (tree.built().cells_expanded > 0) break;
  }
  return searches;
}

/// Searches of `size` references that cost as much, less the last one.
std::uint64_t searches_for(std::uint64_t cost, std::uint64_t size) {
  return (cost + cost_of_search(size) - 1) / cost_of_search(size) - 1;
}

TEST(Demand, SearchesASmallMeshUntilThatHasCostAsMuchAsItsBlocks) {
  const TestMesh mesh = tests::icosphere(2);
  AskedTree tree(mesh, "scan-fast");
  const std::uint64_t size = mesh.faces.size();
  EXPECT_EQ(searches_before_building(tree, {{3, 0.1, 0.2}, {-1, 0, 0}}),
            searches_for(kBlocksCost * size, size));
}

TEST(Demand, SearchesATangleUntilThatHasCostAsMuchAsAllOfIt) {
  const TestMesh mesh = tests::slivers(4000, 2);
  AskedTree tree(mesh, "scan-fast");
  const std::uint64_t size = mesh.faces.size();
  const Ray ray{{0.5, 0.5, 0.5}, {-1, 0, 0}};
  EXPECT_EQ(searches_before_building(tree, ray), searches_for(kDenseCost * size, size));
  for (std::uint64_t i = 0; i < kPathCost; ++i) tree.nearest(ray, Growth::kDemand);
  const std::uint64_t cells = tree.built().cells_expanded;
  tree.nearest(ray, Growth::kDemand);
  EXPECT_EQ(tree.built().cells_expanded, cells) << "cells below wait no longer";
  AskedTree first_touch(mesh, "scan-fast");
  first_touch.nearest(ray);
  EXPECT_EQ(cells, first_touch.built().cells_expanded);
}

TEST(Demand, FindsTheSameHitsAsTheRule) {
  for (const auto& [name, mesh] : subjects()) {
    SCOPED_TRACE(name);
    AskedTree tree(mesh, "scan-fast");
    const std::vector<Ray> rays = tests::make_hard_rays(mesh, 200, 4);
    for (int again = 0; again < 3; ++again) {
      for (const Ray& ray : rays)
        ASSERT_EQ(tree.nearest(ray, Growth::kDemand), tests::nearest_without_tree(mesh, ray));
    }
  }
}

struct Figures {
  std::uint64_t cells, touches, steps, tests, bytes;
  bool operator==(const Figures&) const = default;
};

Figures figures(const AskedTree& tree) {
  return {tree.built().cells_expanded, tree.built().touches, tree.walked().steps,
          tree.walked().tests, tree.metrics().bytes};
}

TEST(Demand, MakesTheSameTreesOfTheSameRequests) {
  for (const auto& [name, mesh] : subjects()) {
    AskedTree one(mesh, "scan-fast"), other(mesh, "scan-fast");
    for (const Ray& ray : tests::make_hard_rays(mesh, 300, 5)) {
      one.nearest(ray, Growth::kDemand);
      other.nearest(ray, Growth::kDemand);
    }
    EXPECT_EQ(figures(one), figures(other)) << name;
  }
}

/// What a ray spends on searching is at most what its path costs to build, and its share of cells
/// that it will not expand.
TEST(Demand, SpendsNoMoreOnSearchingThanOnBuilding) {
  const TestMesh mesh = tests::icosphere(6);
  AskedTree demand(mesh, "scan-fast"), first_touch(mesh, "scan-fast");
  const Ray ray{{3, 0.1, 0.2}, {-1, 0, 0}};
  for (int i = 0; i < 2000; ++i) {
    demand.nearest(ray, Growth::kDemand);
    first_touch.nearest(ray, Growth::kFirstTouch);
  }
  const auto searched = static_cast<double>(demand.walked().tests - first_touch.walked().tests);
  const double path = static_cast<double>(mesh.faces.size()) * 2 * kPathCost +
                      static_cast<double>(grow::kBlockCell) * 2 * kRaysToFinish;
  EXPECT_LE(searched, path);
  EXPECT_EQ(demand.built().cells_expanded, first_touch.built().cells_expanded);
}

}  // namespace
}  // namespace sightline::accel::lazy

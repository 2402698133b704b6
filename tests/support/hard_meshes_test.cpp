// Hard meshes have the requested size and are the same every time; bounds are checked as the table
// says.
#include "tests/support/hard_meshes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <set>

#include "tests/support/hard_rays.h"

namespace sightline::tests {
namespace {

bool same_bits(const TestMesh& a, const TestMesh& b) {
  return a.faces == b.faces && a.vertices.size() == b.vertices.size() &&
         std::memcmp(a.vertices.data(), b.vertices.data(),
                     a.vertices.size() * sizeof(accel::geometry::Vec3f)) == 0;
}

TEST(HardMeshes, HaveAboutTheRequestedNumberOfTriangles) {
  for (const HardMesh& mesh : hard_meshes()) {
    for (const std::uint32_t n : {0u, 1u, 5u, 40u, 700u, 3000u}) {
      const TestMesh made = mesh.make(n, 1);
      EXPECT_LE(made.faces.size(), n) << mesh.name;
      if (n >= 700) {
        EXPECT_GE(made.faces.size(), n / 2) << mesh.name;
      }
      for (const accel::geometry::Face& face : made.faces) {
        for (const std::uint32_t v : face) ASSERT_LT(v, made.vertices.size()) << mesh.name;
      }
    }
  }
}

TEST(HardMeshes, AreTheSameEveryTime) {
  for (const HardMesh& mesh : hard_meshes()) {
    EXPECT_TRUE(same_bits(mesh.make(500, 3), mesh.make(500, 3))) << mesh.name;
  }
}

TEST(HardMeshes, AreFoundByTheirNames) {
  std::set<std::string_view> names;
  for (const HardMesh& mesh : hard_meshes()) {
    EXPECT_TRUE(names.insert(mesh.name).second) << mesh.name;
    EXPECT_EQ(find_hard_mesh(mesh.name), &mesh);
    EXPECT_FALSE(mesh.rows.empty());
  }
  EXPECT_EQ(find_hard_mesh("torus"), nullptr);
}

TEST(HardMeshes, BreachesAreValuesAboveTheBounds) {
  const HardMesh& rods = *find_hard_mesh("rods");
  EXPECT_TRUE(breaches(rods, "scan-fast", {}).empty());  // All costs are unknown
  TreeCost cost{.references = rods.references, .depth = rods.depth, .failed_cells = 0};
  EXPECT_TRUE(breaches(rods, "scan-fast", cost).empty());
  cost.work = rods.work + 1;
  cost.failed_cells = 1;
  const std::vector<Breach> found = breaches(rods, "scan-fast", cost);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].text(), "work 3 over 2");
  EXPECT_EQ(found[0].by_design, "");
  EXPECT_EQ(found[1].text(), "cells given up 1 over 0");
  EXPECT_NE(breaches(rods, "spatial-median", cost)[0].by_design, "");
}

TEST(HardMeshes, LevelsAreCountedBeyondThoseOfAGoodTree) {
  EXPECT_EQ(levels_beyond_good(5, 0), 0);
  EXPECT_EQ(levels_beyond_good(22, 1024), 1);
  EXPECT_EQ(levels_beyond_good(10, 1024), 0);
}

TEST(HardRays, AreValidAndCycleThroughTheirKinds) {
  for (const HardMesh& mesh : hard_meshes()) {
    const TestMesh made = mesh.make(300, 1);
    const auto rays = make_hard_rays(made, 10 * kHardRayKinds, 2);
    ASSERT_EQ(rays.size(), 10 * kHardRayKinds) << mesh.name;
    for (const accel::geometry::Ray& ray : rays) {
      EXPECT_TRUE(is_finite(ray.origin) && is_finite(ray.direction)) << mesh.name;
    }
  }
  EXPECT_TRUE(make_hard_rays({}, 8, 1).empty());
}

}  // namespace
}  // namespace sightline::tests

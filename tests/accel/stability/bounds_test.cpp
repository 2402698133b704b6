// What trees over hard meshes cost stays within what the table allows, and their building grows as
// it should.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/accel/stability/asked_tree.h"
#include "tests/support/hard_meshes.h"
#include "tests/support/hard_rays.h"
#include "tests/support/hard_shapes.h"

namespace sightline::tests {
namespace {

constexpr std::uint64_t kSeed = 7;
constexpr std::uint32_t kTriangles = 1000, kTrianglesIfQuadratic = 300;

std::uint32_t size_for(std::string_view builder) {
  return is_quadratic(builder) ? kTrianglesIfQuadratic : kTriangles;
}

double touches_each(const TestMesh& mesh, std::string_view builder) {
  AskedTree tree(mesh, builder);
  tree.build();
  return static_cast<double>(tree.built().touches) /
         static_cast<double>(std::max<std::size_t>(mesh.faces.size(), 1));
}

TreeCost cost_of(const TestMesh& mesh, std::string_view builder) {
  AskedTree tree(mesh, builder);
  tree.build();
  const accel::TreeMetrics metrics = tree.metrics();
  const auto n = static_cast<double>(mesh.faces.size());
  TreeCost cost;
  cost.references = static_cast<double>(metrics.references) / n;
  cost.depth = levels_beyond_good(metrics.max_depth, mesh.faces.size());
  cost.touches = static_cast<double>(tree.built().touches) / n /
                 touches_each(hills(size_for(builder), kSeed), builder);
  return cost;
}

/// Steps and one and a half tests.
double work_of(const TestMesh& mesh, std::span<const accel::Ray> rays, std::string_view builder) {
  AskedTree tree(mesh, builder);
  tree.build();
  for (const accel::Ray& ray : rays) tree.nearest(ray);
  return static_cast<double>(tree.walked().steps) + 1.5 * static_cast<double>(tree.walked().tests);
}

TEST(HardMeshBounds, AreKeptByEveryBuilderThatIsNotMarked) {
  for (const HardMesh& hard : hard_meshes()) {
    for (const std::string_view builder : accel::builder_names()) {
      const TestMesh mesh = hard.make(size_for(builder), kSeed);
      const std::vector<accel::Ray> rays = make_hard_rays(mesh, 50 * kHardRayKinds, kSeed);
      TreeCost cost = cost_of(mesh, builder);
      cost.work = work_of(mesh, rays, builder) / work_of(mesh, rays, "sah-sweep");
      for (const Breach& breach : breaches(hard, builder, cost)) {
        EXPECT_FALSE(breach.by_design.empty())
            << hard.name << ", " << builder << ": " << breach.text();
      }
    }
  }
}

/// Of builders that are N log N: twice as many triangles are little more than twice the touches.
TEST(HardMeshBounds, TouchesGrowLittleFasterThanTheMesh) {
  constexpr double kMost = 2.5;
  for (const HardMesh& hard : hard_meshes()) {
    const TestMesh small = hard.make(kTriangles, kSeed), large = hard.make(2 * kTriangles, kSeed);
    for (const std::string_view builder : accel::builder_names()) {
      if (is_quadratic(builder)) continue;
      const double rise = touches_each(large, builder) / touches_each(small, builder);
      EXPECT_LE(
          rise * static_cast<double>(large.faces.size()) / static_cast<double>(small.faces.size()),
          kMost)
          << hard.name << ", " << builder;
    }
  }
}

/// Nothing can be separated: one leaf, and the list is read a few times, however long it is.
TEST(HardMeshBounds, DuplicatesAreOneLeafAtOnce) {
  for (const std::string_view builder : accel::builder_names()) {
    const TestMesh mesh = duplicates(is_quadratic(builder) ? 300 : 5000);
    AskedTree tree(mesh, builder);
    tree.build();
    const accel::TreeMetrics metrics = tree.metrics();
    EXPECT_EQ(metrics.nonempty_leaves, 1u) << builder;
    EXPECT_EQ(metrics.references, mesh.faces.size()) << builder;
  }
}

}  // namespace
}  // namespace sightline::tests

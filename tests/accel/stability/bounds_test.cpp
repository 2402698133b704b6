// What trees over hard meshes cost stays within what the table allows, and their building grows as
// it should.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>

#include "accel/published/any_builder.h"
#include "tests/accel/stability/asked_tree.h"
#include "tests/support/hard_meshes.h"
#include "tests/support/hard_rays.h"
#include "tests/support/hard_shapes.h"

namespace sightline::tests {
namespace {

constexpr std::uint64_t kSeed = 7;
constexpr std::uint32_t kTriangles = 600, kTrianglesIfQuadratic = 300;

std::uint32_t size_for(std::string_view builder) {
  return is_quadratic(builder) ? kTrianglesIfQuadratic : kTriangles;
}

double touches_each(const TestMesh& mesh, std::string_view builder) {
  AskedTree tree(mesh, builder);
  tree.build();
  return static_cast<double>(tree.built().touches) /
         static_cast<double>(std::max<std::size_t>(mesh.faces.size(), 1));
}

/// What a builder's tree over a mesh comes to, and its work: steps and one and a half tests.
struct Measured {
  TreeCost cost;
  double touches = 0, work = 0;
};

Measured measure(const TestMesh& mesh, std::span<const accel::geometry::Ray> rays,
                 std::string_view builder) {
  AskedTree tree(mesh, builder);
  tree.build();
  const accel::kdtree::TreeMetrics metrics = tree.metrics();
  const auto n = static_cast<double>(mesh.faces.size());
  Measured measured;
  measured.touches = static_cast<double>(tree.built().touches) / n;
  measured.cost.references = static_cast<double>(metrics.references) / n;
  measured.cost.depth = levels_beyond_good(metrics.max_depth, mesh.faces.size());
  measured.cost.given_up = static_cast<double>(metrics.given_up_cells);
  for (const accel::geometry::Ray& ray : rays) tree.nearest(ray);
  measured.work =
      static_cast<double>(tree.walked().steps) + 1.5 * static_cast<double>(tree.walked().tests);
  return measured;
}

TEST(HardMeshBounds, AreKeptByEveryBuilderThatIsNotMarked) {
  std::map<std::string_view, double> compact;  // touches a triangle
  for (const std::string_view builder : accel::published::builder_names()) {
    compact[builder] = touches_each(hills(size_for(builder), kSeed), builder);
  }
  for (const HardMesh& hard : hard_meshes()) {
    std::map<std::uint32_t, double> sweep;  // work of the exact sweep's tree, by size
    for (const std::string_view builder : accel::published::builder_names()) {
      const std::uint32_t size = size_for(builder);
      const TestMesh mesh = hard.make(size, kSeed);
      const std::vector<accel::geometry::Ray> rays =
          make_hard_rays(mesh, 20 * kHardRayKinds, kSeed);
      if (!sweep.contains(size)) sweep[size] = measure(mesh, rays, "sah-sweep").work;
      Measured measured = measure(mesh, rays, builder);
      measured.cost.touches = measured.touches / compact[builder];
      measured.cost.work = measured.work / sweep[size];
      for (const Breach& breach : breaches(hard, builder, measured.cost)) {
        EXPECT_TRUE(!breach.by_design.empty())
            << hard.name << ", " << builder << ": " << breach.text();
      }
    }
  }
}

/// Of builders that are N log N: twice as many triangles are little more than twice the touches.
TEST(HardMeshBounds, TouchesGrowLittleFasterThanTheMesh) {
  constexpr std::uint32_t kFewer = 3000;
  const double power = std::log2(2.5);
  for (const HardMesh& hard : hard_meshes()) {
    const TestMesh small = hard.make(kFewer, kSeed), large = hard.make(2 * kFewer, kSeed);
    const auto n = static_cast<double>(small.faces.size());
    const double times = static_cast<double>(large.faces.size()) / n;
    for (const std::string_view builder : accel::published::builder_names()) {
      const auto excused = [&](Bound bound) {
        return !design_failure(hard.name, builder, bound).empty();
      };
      if (is_quadratic(builder) || excused(Bound::kReferences) || excused(Bound::kTouches)) {
        continue;
      }
      // A few passes over the root's list, one more or less at either size, say nothing.
      const double passes = 10;
      EXPECT_LE(times * touches_each(large, builder),
                std::pow(times, power) * touches_each(small, builder) + times * passes)
          << hard.name << ", " << builder;
    }
  }
}

/// Nothing can be separated: a cell is a leaf at once, however many they are; a hierarchy of boxes
/// may divide them, as its leaves have a limit, but makes no references.
TEST(HardMeshBounds, DuplicatesAreNotCut) {
  for (const std::string_view builder : accel::published::builder_names()) {
    if (!design_failure("duplicates", builder, Bound::kReferences).empty()) continue;
    const TestMesh mesh = duplicates(is_quadratic(builder) ? 300 : 5000);
    AskedTree tree(mesh, builder);
    tree.build();
    const accel::kdtree::TreeMetrics metrics = tree.metrics();
    EXPECT_EQ(metrics.references, mesh.faces.size()) << builder;
    const bool cells = builder.find("bvh") == std::string_view::npos;
    EXPECT_LE(metrics.nonempty_leaves, cells ? 1 : mesh.faces.size()) << builder;
  }
}

}  // namespace
}  // namespace sightline::tests

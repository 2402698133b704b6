// For every hard mesh, the trees of all builders, full and growing, give the right hits.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "accel/published/any_builder.h"
#include "tests/accel/stability/asked_tree.h"
#include "tests/accel/stability/catalogue.h"
#include "tests/support/brute_force.h"
#include "tests/support/compare_hits.h"
#include "tests/support/hard_meshes.h"
#include "tests/support/hard_rays.h"
#include "tests/support/rounds.h"

namespace sightline::tests {
namespace {

constexpr std::uint32_t kMeshSize = 400;
constexpr std::size_t kRays = rounds(25) * kHardRayKinds;
// Rays checked with the oracle, which is slow.
constexpr std::size_t kSample = 8 * kHardRayKinds;
constexpr std::uint64_t kMeshSeed = 7;

accel::geometry::Hit as_hit(const NearestHit& nearest) {
  accel::geometry::Hit hit;
  if (nearest.t == accel::geometry::kInfinity) return hit;
  hit.t = nearest.t;
  hit.node = 1;
  hit.primitive = nearest.primitive;
  hit.state = accel::geometry::HitState::kHit;
  return hit;
}

class HardMeshHits : public ::testing::TestWithParam<std::string_view> {
 protected:
  static TestMesh make(std::uint32_t triangles, std::uint64_t seed) {
    return find_hard_mesh(GetParam())->make(triangles, seed);
  }
};

TEST_P(HardMeshHits, WithoutATreeEqualTheOracles) {
  const TestMesh mesh = make(kMeshSize, kMeshSeed);
  const std::vector<accel::geometry::Ray> rays = make_hard_rays(mesh, kSample, kMeshSeed);
  ASSERT_EQ(rays.size(), kSample);
  std::vector<accel::geometry::Hit> hits;
  for (const NearestHit& hit : nearest_without_tree(mesh, rays)) hits.push_back(as_hit(hit));
  const Comparison comparison = compare(rays, hits, BruteForce({{mesh.view()}}));
  EXPECT_TRUE(comparison.clean()) << comparison.report();
  EXPECT_GT(comparison.hits, kSample / 10);
}

TEST_P(HardMeshHits, FullAndGrowingTreesAgree) {
  const TestMesh mesh = make(kMeshSize, kMeshSeed);
  const std::vector<accel::geometry::Ray> rays = make_hard_rays(mesh, kRays, kMeshSeed);
  expect_right(mesh, rays);
}

/// The lines of those rays, begun as far away as rays are valid. One builder stands for each form
/// of tree: plain trees answer such rays slowly, as their boxes are met with large errors.
TEST_P(HardMeshHits, OfRaysFromAfarAreRight) {
  const TestMesh mesh = make(kMeshSize, kMeshSeed);
  std::vector<accel::geometry::Ray> rays = make_hard_rays(mesh, 2 * kHardRayKinds, kMeshSeed);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    accel::geometry::Ray& ray = rays[i];
    ray.direction = ray.direction * (1 / accel::geometry::max_norm(ray.direction));
    ray.origin = ray.origin - ray.direction * std::exp2(56 + static_cast<double>(11 * i % 190));
  }
  expect_right(mesh, rays, {"scan-fast", "scan-best", "sah-sweep", "bvh-sweep"});
}

/// No triangle, one triangle, two, ...: the smallest meshes.
TEST_P(HardMeshHits, OfZeroToFortyTriangles) {
  for (std::uint32_t n = 0; n <= 40; n += n < 8 || !kSanitized ? 1 : 4) {
    const TestMesh mesh = make(n, n);
    std::vector<accel::geometry::Ray> rays = make_hard_rays(mesh, 2 * kHardRayKinds, n);
    if (rays.empty()) rays = {{{0, 0, 0}, {1, 0, 0}}, {{0.5, 0.5, 3}, {0, 0, -1}}};
    const std::vector<NearestHit> expected = nearest_without_tree(mesh, rays);
    for (const std::string_view builder : accel::published::builder_names()) {
      AskedTree full(mesh, builder), growing(mesh, builder);
      full.build();
      for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(full.nearest(rays[i]), expected[i]) << builder << " of " << n << " ray " << i;
        ASSERT_EQ(growing.nearest(rays[i]), expected[i]) << builder << " of " << n << " ray " << i;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Catalogue, HardMeshHits, ::testing::ValuesIn(hard_mesh_names()),
                         hard_mesh_test_name);

}  // namespace
}  // namespace sightline::tests

// Faces that are left out are misses, on every SIMD target, and most misses are left out.
#include "accel/geometry/vertex_sides.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "accel/geometry/intersect.h"
#include "tests/accel/simd_targets.h"
#include "tests/support/hard_shapes.h"
#include "tests/support/random.h"

namespace sightline::accel::geometry {
namespace {

using tests::TestMesh;

TestMesh soup(double size, const Vec3d& at) {
  TestMesh mesh = tests::random_soup(301, 0.05, 3);
  for (Vec3f& v : mesh.vertices) v = Vec3f(at + Vec3d(v) * size);
  return mesh;
}

/// Through the mesh, at corners and edges.
std::vector<LocalRay> rays_towards(const TestMesh& mesh, double distance, std::uint64_t seed) {
  tests::Random random(seed);
  std::vector<LocalRay> rays;
  while (rays.size() < 150) {
    const Face& face = mesh.faces[random.below(mesh.faces.size())];
    const Vec3d a(mesh.vertices[face[0]]), b(mesh.vertices[face[1]]);
    const Vec3d target = a + (b - a) * (random.below(2) == 0 ? 0 : random.uniform());
    const Vec3d origin = target + random.direction() * distance;
    if (const auto ray = make_local_ray(origin, target - origin)) rays.push_back(*ray);
  }
  return rays;
}

/// The share of all faces that are kept.
double expect_no_hit_lost(const TestMesh& mesh, const std::vector<LocalRay>& rays) {
  std::vector<std::uint8_t> sides(mesh.vertices.size());
  std::vector<std::uint32_t> kept(mesh.faces.size());
  std::size_t all_kept = 0;
  for (const LocalRay& ray : rays) {
    vertex_sides(sheared(ray), mesh.vertices, sides.data());
    const auto faces = static_cast<std::uint32_t>(mesh.faces.size());
    const std::size_t count = faces_on_no_side(mesh.faces, 0, faces, sides.data(), kept.data());
    all_kept += count;
    std::size_t next = 0;
    for (std::uint32_t i = 0; i < faces; ++i) {
      const bool is_kept = next < count && kept[next] == i;
      next += is_kept ? 1 : 0;
      const Face& f = mesh.faces[i];
      const bool hit =
          intersect(ray, mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]).has_value();
      EXPECT_TRUE(is_kept || !hit) << "face " << i;
    }
    EXPECT_EQ(next, count);
  }
  return static_cast<double>(all_kept) / static_cast<double>(rays.size() * mesh.faces.size());
}

using VertexSides = tests::OnSimdTarget;

TEST_P(VertexSides, LoseNoHitAndKeepFewFaces) {
  for (const double size : {1.0, 1e-3, 1e8}) {
    for (const double distance : {0.1, 10.0, 1000.0}) {
      const TestMesh mesh = soup(size, {size, -3 * size, 0});
      EXPECT_LE(expect_no_hit_lost(mesh, rays_towards(mesh, distance * size, 2)), 0.05)
          << size << " from " << distance;
    }
  }
}

TEST_P(VertexSides, LoseNoHitWhereFloatsAreCoarseAndAtTheEndsOfTheRange) {
  for (const double far : {1e3, 1e5, 1e7, 1e12}) {
    const TestMesh mesh = soup(1, {far, -far / 3, far / 7});
    expect_no_hit_lost(mesh, rays_towards(mesh, 5, 4));
    expect_no_hit_lost(mesh, rays_towards(mesh, far, 5));
  }
  for (const double size : {1e38, 1e37, 1e19, 1e-20, 1e-37, 1e-42}) {
    const TestMesh mesh = soup(size, {});
    for (const double distance : {0.5, 3.0, 1e6})
      expect_no_hit_lost(mesh, rays_towards(mesh, distance * size, 7));
  }
}

/// Bits of vertices are right, and few of those outside have none.
TEST_P(VertexSides, OfAPartOfSpaceAreThoseOfVerticesOutside) {
  tests::Random random(8);
  for (const double size : {1.0, 1e-3, 1e8, 1e30, 1e-30}) {
    const TestMesh mesh = soup(size, {size, -3 * size, 0});
    std::vector<std::uint8_t> sides(mesh.vertices.size());
    std::size_t outside = 0, missed = 0;
    for (int i = 0; i < 50; ++i) {
      const Vec3d at(mesh.vertices[random.below(mesh.vertices.size())]);
      const Vec3f normal(random.direction());
      CutBox part{{}, normal, static_cast<float>(dot(Vec3d(normal), at))};
      for (const double way : {-1.0, 1.0})
        part.box.grow(Vec3f(at + Vec3d{1, 2, 0.5} * (0.3 * way * size)));
      vertex_sides(part, mesh.vertices, sides.data());
      for (std::size_t v = 0; v < sides.size(); ++v) {
        const Vec3d p(mesh.vertices[v]);
        const double beyond = dot(Vec3d(normal), p) - static_cast<double>(part.most);
        int expected = beyond > 0 ? 64 : 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if (mesh.vertices[v][axis] < part.box.lo[axis]) expected |= 1 << 2 * axis;
          if (mesh.vertices[v][axis] > part.box.hi[axis]) expected |= 2 << 2 * axis;
        }
        ASSERT_EQ(sides[v] & ~expected, 0);
        ASSERT_EQ(sides[v] | 64, expected | 64);
        outside += (expected & 64) != 0 ? 1 : 0;
        missed += sides[v] != expected ? 1 : 0;
      }
    }
    EXPECT_LT(missed, outside / 100) << size;
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, VertexSides, tests::every_simd_target(), tests::simd_target_name);

}  // namespace
}  // namespace sightline::accel::geometry

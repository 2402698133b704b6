// The prefilter rejects only misses, on every SIMD target, and it rejects most of them.
#include "accel/geometry/triangle_prefilter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <vector>

#include "accel/geometry/intersect.h"
#include "tests/accel/simd_targets.h"
#include "tests/support/random.h"

namespace sightline::accel::geometry {
namespace {

struct Soup {
  std::vector<Vec3f> vertices;
  std::vector<Face> faces;

  MeshView view() const { return {vertices, faces}; }
  std::array<Vec3f, 3> corners(std::size_t face) const {
    const Face& f = faces[face];
    return {vertices[f[0]], vertices[f[1]], vertices[f[2]]};
  }
};

/// Triangles of a given size around a point. The last vertex is also a corner.
Soup make_soup(std::size_t triangles, double size, const Vec3d& at, std::uint64_t seed) {
  tests::Random random(seed);
  Soup soup;
  for (std::uint32_t i = 0; i < triangles; ++i) {
    const Vec3d center =
        at + Vec3d{random.uniform(), random.uniform(), random.uniform()} * (4 * size);
    for (int corner = 0; corner < 3; ++corner)
      soup.vertices.push_back(Vec3f(center + random.direction() * size));
    soup.faces.push_back({3 * i, 3 * i + 2, 3 * i + 1});
  }
  return soup;
}

std::vector<std::uint32_t> all_faces(const Soup& soup) {
  std::vector<std::uint32_t> faces(soup.faces.size());
  std::iota(faces.begin(), faces.end(), 0u);
  return faces;
}

using CertainMisses = tests::OnSimdTarget;

/// The misses that are not rejected, of all misses. Cycles through all batch sizes.
double share_left(const Soup& soup, const std::vector<LocalRay>& rays) {
  const std::vector<std::uint32_t> faces = all_faces(soup);
  std::uint64_t misses = 0, left = 0;
  std::size_t size = 1;
  for (const LocalRay& ray : rays) {
    const ShearedRay seen = sheared(ray);
    for (std::size_t begin = 0; begin < faces.size(); size = size % kPrefilterBatch + 1) {
      const auto batch = std::span(faces).subspan(begin, std::min(size, faces.size() - begin));
      const std::uint64_t possible = candidate_mask(soup.view(), seen, batch);
      EXPECT_TRUE(batch.size() == kPrefilterBatch || possible >> batch.size() == 0);
      for (std::size_t i = 0; i < batch.size(); ++i) {
        const auto [a, b, c] = soup.corners(batch[i]);
        const bool hit = intersect(ray, a, b, c).has_value(), kept = (possible >> i & 1) != 0;
        EXPECT_TRUE(kept || !hit) << "face " << batch[i];
        misses += hit ? 0 : 1;
        left += kept && !hit ? 1 : 0;
      }
      begin += batch.size();
    }
  }
  return static_cast<double>(left) / static_cast<double>(std::max<std::uint64_t>(misses, 1));
}

/// From far away through a soup, at random points, corners and edges.
std::vector<LocalRay> rays_at(const Soup& soup, std::size_t count, double distance,
                              std::uint64_t seed) {
  tests::Random random(seed);
  std::vector<LocalRay> rays;
  while (rays.size() < count) {
    const auto corners = soup.corners(random.below(soup.faces.size()));
    const Vec3d a(corners[0]), b(corners[1]), c(corners[2]);
    const double u = random.below(2) == 0 ? 0 : random.uniform(), v = random.uniform() * (1 - u);
    const Vec3d target = a + (b - a) * u + (c - a) * v;
    const Vec3d origin = target + random.direction() * distance;
    if (const auto ray = make_local_ray(origin, target - origin)) rays.push_back(*ray);
  }
  return rays;
}

TEST_P(CertainMisses, RejectsNoHit) {
  const bool filters = GetParam() != HWY_SCALAR;
  for (const double size : {1.0, 1e-3, 1e8}) {
    for (const double distance : {0.1, 10.0, 1000.0}) {
      const Soup soup = make_soup(500, size, {size, -3 * size, 0}, 1);
      const double left = share_left(soup, rays_at(soup, 200, distance * size, 2));
      EXPECT_LE(left, filters ? 0.02 : 1.0) << size << " from " << distance;
    }
  }
}

/// Where floats are coarser than triangles, no hit may be rejected; any number may be left to test.
TEST_P(CertainMisses, RejectsNoHitWhereFloatsAreCoarse) {
  for (const double far : {1e3, 1e5, 1e7, 1e12}) {
    const Soup soup = make_soup(300, 1, {far, -far / 3, far / 7}, 3);
    share_left(soup, rays_at(soup, 100, 5, 4));
    share_left(soup, rays_at(soup, 100, far, 5));
  }
}

TEST_P(CertainMisses, RejectsNoHitAtTheEndsOfTheRange) {
  for (const double size : {1e38, 1e37, 1e19, 3e18, 1e-20, 1e-30, 1e-37, 1e-42}) {
    const Soup soup = make_soup(200, size, {}, 6);
    for (const double distance : {0.5, 3.0, 1e6})
      share_left(soup, rays_at(soup, 50, distance * size, 7));
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, CertainMisses, tests::every_simd_target(),
                         tests::simd_target_name);

}  // namespace
}  // namespace sightline::accel::geometry

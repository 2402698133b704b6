// Hits do not depend on whether the processor flushes denormal numbers to zero.
#include <gtest/gtest.h>

#include <string>

#include "accel/published/any_builder.h"
#include "tests/accel/stability/asked_tree.h"
#include "tests/support/flush_denormals.h"
#include "tests/support/hard_meshes.h"
#include "tests/support/hard_rays.h"
#include "tests/support/rounds.h"

namespace sightline::tests {
namespace {

#if defined(__SSE2__)

TestMesh shrunk(TestMesh mesh, float factor) {
  for (accel::geometry::Vec3f& v : mesh.vertices) v = v * factor;
  return mesh;
}

/// All coordinates of the mesh are normal numbers or zero.
TestMesh without_denormals(TestMesh mesh) {
  for (accel::geometry::Vec3f& v : mesh.vertices) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (std::fabs(v[axis]) < std::numeric_limits<float>::min()) v[axis] = 0;
    }
  }
  return mesh;
}

std::vector<TestMesh> small_things() {
  return {find_hard_mesh("denormal")->make(500, 3), shrunk(icosphere(3), 1e-37f),
          shrunk(icosphere(3), 1e-40f), shrunk(random_soup(300, 0.2, 1), 3e-38f)};
}

/// Trees of all builders that were built before, are built, or grow while denormals are flushed.
void expect_unchanged_hits(const TestMesh& mesh, bool inputs) {
  const std::vector<accel::geometry::Ray> rays =
      make_hard_rays(mesh, rounds(10) * kHardRayKinds, 5);
  const std::vector<NearestHit> expected = nearest_without_tree(mesh, rays);
  for (const std::string_view builder : accel::published::builder_names()) {
    AskedTree before(mesh, builder);
    before.build();
    const FlushDenormals flush(inputs);
    AskedTree full(mesh, builder), growing(mesh, builder);
    full.build();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(before.nearest(rays[i]), expected[i]) << builder << " ray " << i;
      ASSERT_EQ(full.nearest(rays[i]), expected[i]) << builder << " ray " << i;
      ASSERT_EQ(growing.nearest(rays[i]), expected[i]) << builder << " ray " << i;
    }
  }
}

TEST(FlushedDenormals, OfResultsChangeNoHit) {
  for (const TestMesh& mesh : small_things()) expect_unchanged_hits(mesh, false);
}

/// Denormal vertices then become other vertices; for the rest all trees of all builders agree.
TEST(FlushedDenormals, OfOperandsChangeNoHitOfNormalVertices) {
  for (const TestMesh& mesh : small_things()) expect_unchanged_hits(without_denormals(mesh), true);
}

#endif

/// A direction's length only sets the unit of t.
TEST(TinyDirections, HitTheSameTriangles) {
  const TestMesh mesh = icosphere(3);
  const std::vector<accel::geometry::Ray> rays =
      make_hard_rays(mesh, rounds(10) * kHardRayKinds, 6);
  for (const std::string_view builder : accel::published::builder_names()) {
    AskedTree tree(mesh, builder);
    for (accel::geometry::Ray ray : rays) {
      ray.tmin = 0;
      ray.tmax = accel::geometry::kInfinity;
      const NearestHit expected = tree.nearest(ray);
      for (const double factor : {0x1p-300, 0x1p-900, 0x1p+300}) {
        accel::geometry::Ray scaled = ray;
        scaled.direction = ray.direction * factor;
        const NearestHit hit = tree.nearest(scaled);
        ASSERT_EQ(hit.primitive, expected.primitive) << builder;
        ASSERT_EQ(hit.t * factor, expected.t) << builder;
      }
    }
  }
}

}  // namespace
}  // namespace sightline::tests

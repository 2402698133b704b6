// The families' rays have their documented properties, and the certain answers are right.
#include "tests/bench/verbs/robust_family.h"
#include "accel/published/any_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "tests/bench/scenes/scene_geometry.h"
#include "tests/bench/verbs/robust_method.h"

namespace sightline::bench {
namespace {

using accel::geometry::Ray;
using accel::geometry::Vec3d;

RobustFamily sphere(double offset) {
  return {"sphere",
          make_robust_families(offset == 0 ? "icosphere-0" : "icosphere-1e7", 3, "")
              .value()
              .front()
              .scene,
          true};
}

RobustFamily boxed() {
  return std::move(make_robust_families("mesh-in-box", 3, "gen:icosphere?level=2").value().front());
}

TEST(RobustFamily, IsFoundByAPrefixOfItsName) {
  const auto spheres = make_robust_families("icosphere", 1, "");
  ASSERT_TRUE(spheres.ok());
  EXPECT_EQ(spheres->size(), 4u);
  const auto all = make_robust_families("", 1, "gen:icosphere?level=1");
  ASSERT_TRUE(all.ok());
  EXPECT_EQ(all->size(), robust_family_names().size());
  const auto none = make_robust_families("cube", 1, "");
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, Code::kInvalidArgument);
  EXPECT_NE(none.error().message.find("mesh-in-box"), std::string::npos);
  EXPECT_FALSE(make_robust_families("mesh-in-box", 1, "/nonexistent.ply").ok());
}

TEST(RobustFamily, RaysOfEveryKindAreTheSameEveryTime) {
  const RobustFamily family = sphere(0);
  for (const std::string_view kind : robust_ray_kinds()) {
    const auto rays = make_robust_rays(family, kind, 40, 3);
    const auto again = make_robust_rays(family, kind, 40, 3);
    const auto other = make_robust_rays(family, kind, 40, 4);
    ASSERT_EQ(rays.size(), 40u);
    EXPECT_EQ(rays[7].origin, again[7].origin) << kind;
    EXPECT_NE(rays[7].origin, other[7].origin) << kind;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      EXPECT_EQ(length(rays[i].origin) > 1, i % 2 == 0) << kind << " " << i;
    }
  }
}

TEST(RobustFamily, AxisRaysRunAlongAnAxisThroughVertices) {
  const RobustFamily family = boxed();
  const SceneGeometry geometry(family.scene);
  std::size_t through_vertex = 0;
  for (const Ray& ray : make_robust_rays(family, "axis", 60, 1)) {
    std::size_t across = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_GT(ray.origin[a], geometry.lo()[a]);
      EXPECT_LT(ray.origin[a], geometry.hi()[a]);
      across += ray.direction[a] == 0;
    }
    EXPECT_EQ(across, 2u);
    for (std::uint64_t n = 0; n < geometry.triangles(); ++n) {
      const auto corners = geometry.triangle(n);
      const bool met = std::any_of(corners.begin(), corners.end(), [&](const Vec3d& v) {
        return length(cross(v - ray.origin, ray.direction)) == 0;
      });
      if (met) {
        ++through_vertex;
        break;
      }
    }
  }
  EXPECT_GE(through_vertex, 30u);
}

TEST(SphereTruth, GivesTheCertainAnswers) {
  for (const double offset : {0.0, 1e7}) {
    const SphereTruth truth(sphere(offset).scene);
    const auto bounds = [&](const Vec3d& origin, const Vec3d& direction) {
      Ray ray;
      ray.origin = origin + Vec3d{offset, offset, offset};
      ray.direction = direction;
      return truth.bounds(ray);
    };
    const CrossingBounds through = bounds({-3, 0.1, 0.2}, {2, 0, 0});
    EXPECT_EQ(through.least, 2u);
    EXPECT_EQ(through.most, 2u);
    const CrossingBounds inside = bounds({0.1, 0, 0.2}, {0, 0, -1});
    EXPECT_EQ(inside.least, 1u);
    EXPECT_EQ(inside.most, 1u);
    EXPECT_EQ(bounds({-3, 1.1, 0}, {1, 0, 0}).most, 0u);
    EXPECT_EQ(bounds({-3, 0, 0}, {-1, 0, 0}).most, 0u);
    const CrossingBounds grazing = bounds({-3, 0.999999, 0}, {1, 0, 0});
    EXPECT_EQ(grazing.least, 0u);
    EXPECT_TRUE(grazing.even);
  }
}

TEST(RobustMethod, ExactAnswersAreCorrect) {
  for (const double offset : {0.0, 1e7}) {
    const RobustFamily family = sphere(offset);
    const SphereTruth truth(family.scene);
    const auto full =
        make_exact_full(family.scene, "scan-fast", accel::published::default_builder()).value();
    const auto lazy =
        make_exact_lazy(family.scene, "scan-fast", accel::published::default_builder());
    EXPECT_EQ(full->policy(), "full");
    EXPECT_EQ(lazy->policy(), "first-touch");
    for (const std::string_view kind : robust_ray_kinds()) {
      const auto rays = make_robust_rays(family, kind, 300, 2);
      std::vector<accel::geometry::Hit> hits(rays.size());
      std::vector<std::uint32_t> counts(rays.size()), lazy_counts(rays.size());
      ASSERT_TRUE(full->trace(rays, hits).ok());
      ASSERT_TRUE(full->count(rays, counts).ok());
      ASSERT_TRUE(lazy->count(rays, lazy_counts).ok());
      EXPECT_EQ(counts, lazy_counts);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        const CrossingBounds allowed = truth.bounds(rays[i]);
        EXPECT_GE(counts[i], allowed.least) << kind << " " << i;
        EXPECT_LE(counts[i], allowed.most) << kind << " " << i;
        EXPECT_FALSE(allowed.even && counts[i] % 2 != 0) << kind << " " << i;
        EXPECT_EQ(hits[i].state == accel::geometry::HitState::kHit, counts[i] > 0)
            << kind << " " << i;
      }
    }
  }
}

TEST(RobustMethod, PlainFloatHasVerticesInWorldSpace) {
  const SceneSource flat = in_float_world(sphere(1e7).scene);
  ASSERT_EQ(flat.nodes.size(), 1u);
  EXPECT_EQ(flat.nodes[0].parent_from_local, scenegraph::model::Affine{});
  // The remains of a unit sphere: whole numbers.
  for (const accel::geometry::Vec3f& v : flat.meshes[0].vertices) {
    EXPECT_GE(v.x, 9'999'999.0f);
    EXPECT_LE(v.x, 10'000'001.0f);
  }
}

}  // namespace
}  // namespace sightline::bench

// Rays made for a ball, which the test casts itself.
#include "client/load/ray_kinds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <type_traits>

#include "client/cli/picture/camera.h"

namespace sightline::client::load {
namespace {

using cli::picture::add;
using cli::picture::dot;
using cli::picture::length;
using cli::picture::scale;
using cli::picture::sub;

constexpr std::array<double, 3> kCenter{10, 0, 0};

SceneInfo ball() {
  SceneInfo scene;
  scene.bounds = {9, -1, -1, 11, 1, 1};
  return scene;
}

// The distance along the ray, of a ball of radius 1.
Found cast_one(const Ray& ray) {
  const auto to = sub(ray.origin, kCenter);
  const double a = dot(ray.direction, ray.direction), b = dot(to, ray.direction);
  const double square = b * b - a * (dot(to, to) - 1);
  Found found{.t = std::numeric_limits<double>::infinity()};
  if (square < 0) return found;
  for (const double t : {(-b - std::sqrt(square)) / a, (-b + std::sqrt(square)) / a}) {
    if (t < ray.tmin || t > ray.tmax) continue;
    found.t = t;
    found.normal = sub(add(ray.origin, scale(ray.direction, t)), kCenter);
    return found;
  }
  return found;
}

Result<std::vector<Found>> cast(std::span<const Ray> rays) {
  std::vector<Found> found;
  for (const Ray& ray : rays) found.push_back(cast_one(ray));
  return found;
}

Result<std::vector<Found>> cast_nothing(std::span<const Ray> rays) {
  return std::vector<Found>(rays.size(), {.t = std::numeric_limits<double>::infinity()});
}

std::size_t hits_of(const RaySet& rays) {
  std::size_t hits = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (std::isfinite(cast_one(rays.at(i)).t)) ++hits;
  }
  return hits;
}

RaySet rays_of(RayKind kind, double coverage, std::size_t count) {
  const auto maker = RayMaker::make(kind, ball(), cast, 1);
  EXPECT_TRUE(maker);
  return maker->rays(coverage, count);
}

TEST(RayKinds, AreTheSameForASeed) {
  for (const auto& [name, kind] : kRayKinds) {
    const RaySet once = rays_of(kind, 0.5, 100), again = rays_of(kind, 0.5, 100);
    for (std::size_t i = 0; i < once.size(); ++i) {
      EXPECT_EQ(once.at(i).origin, again.at(i).origin) << name;
      EXPECT_EQ(once.at(i).direction, again.at(i).direction) << name;
    }
  }
}

TEST(RayKinds, ThatAimAtTheSceneMostlyHitIt) {
  for (const RayKind kind : {RayKind::kOverview, RayKind::kCloseup, RayKind::kRandom})
    EXPECT_GT(hits_of(rays_of(kind, 1, 1000)), 900u);
}

TEST(RayKinds, DiffuseRaysLeaveTheSurface) {
  const RaySet rays = rays_of(RayKind::kDiffuse, 1, 1000);
  EXPECT_LT(hits_of(rays), 20u) << "a ball hides no part of its sky";
  for (std::size_t i = 0; i < rays.size(); ++i)
    EXPECT_NEAR(length(sub(rays.at(i).origin, kCenter)), 1, 1e-5);
}

TEST(RayKinds, ShadowRaysEndBeforeTheLight) {
  const RaySet rays = rays_of(RayKind::kShadow, 1, 100);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Ray ray = rays.at(i);
    EXPECT_LT(ray.tmax, 1);
    EXPECT_GT(add(ray.origin, ray.direction)[1], 3);
  }
}

TEST(RayKinds, CoverageKeepsRaysTogether) {
  const RaySet few = rays_of(RayKind::kOverview, 0.01, 1000);
  EXPECT_EQ(few.size(), 1000u);
  std::array<double, 3> low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
  for (std::size_t i = 0; i < few.size(); ++i) {
    const Ray ray = few.at(i);
    const auto point = add(ray.origin, scale(ray.direction, cast_one(ray).t));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], point[axis]);
      high[axis] = std::max(high[axis], point[axis]);
    }
  }
  EXPECT_LT(length(sub(high, low)), 0.8) << "of a ball of diameter 2";
  EXPECT_NE(few.at(0).direction, few.at(999).direction);
}

TEST(RayKinds, ScenesFarFromZeroGetDoubles) {
  SceneInfo scene = ball();
  const auto is_double = [](const RaySet& set) {
    return set.with(0, 0, [](const auto& columns) {
      return std::is_same_v<decltype(columns), const RayColumns<const double>&>;
    });
  };
  EXPECT_FALSE(is_double(rays_of(RayKind::kRandom, 1, 10)));
  scene.bounds = {1e7, 0, 0, 1e7 + 2, 2, 2};
  const auto hit_all = [](std::span<const Ray> rays) -> Result<std::vector<Found>> {
    return std::vector<Found>(rays.size(), {1, {1, 0, 0}});
  };
  const auto maker = RayMaker::make(RayKind::kRandom, scene, hit_all, 1);
  ASSERT_TRUE(maker);
  EXPECT_TRUE(is_double(maker->rays(1, 10)));
}

TEST(RayKinds, AnEmptySceneOrOneThatIsNotHitIsAnError) {
  const auto empty = RayMaker::make(RayKind::kOverview, SceneInfo(), cast, 1);
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().reason, "NO_TRIANGLES");
  const auto missed = RayMaker::make(RayKind::kOverview, ball(), cast_nothing, 1);
  ASSERT_FALSE(missed);
  EXPECT_EQ(missed.error().reason, "TOO_FEW_HITS");
}

TEST(RayKinds, PartOfAFileIsAroundOneOfItsHits) {
  std::vector<Ray> rays;
  for (int i = 0; i < 100; ++i) rays.push_back({{9 + i * 0.02, 0, 5}, {0, 0, -1}});
  const RaySet all = RaySet::of(rays, RaySet::Precision::kDouble);
  const auto part = part_of(all, 0.1, ball(), cast, 1);
  ASSERT_TRUE(part);
  ASSERT_EQ(part->size(), 10u);
  EXPECT_NEAR(part->at(9).origin[0] - part->at(0).origin[0], 0.18, 0.05);
  EXPECT_FALSE(part_of(all, 0.1, ball(), cast_nothing, 1));
}

}  // namespace
}  // namespace sightline::client::load

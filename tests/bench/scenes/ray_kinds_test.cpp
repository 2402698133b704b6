// Every kind of ray has its documented properties, and is the same every time.
#include "tests/bench/scenes/ray_kinds.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "scenegraph/trace.h"
#include "tests/bench/scenes/generators.h"
#include "tests/bench/scenes/scene_geometry.h"

namespace sightline::bench {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;
using accel::geometry::Vec3d;

constexpr const char* kNames[] = {"overview", "closeup", "diffuse", "shadow", "random", "aimed"};

class RayKinds : public testing::Test {
 protected:
  std::vector<Ray> rays(const char* kind, std::size_t count, std::uint64_t seed = 1) const {
    auto made = make_rays(city_, parse_ray_kind(kind).value(), count, seed);
    EXPECT_TRUE(made.ok()) << made.error().message;
    return std::move(made).value();
  }

  std::vector<Hit> trace(const std::vector<Ray>& rays) const {
    std::vector<Hit> hits(rays.size());
    const auto snapshot = assemble(city_, {});
    EXPECT_TRUE(scenegraph::trace(**snapshot, rays, hits, {}).ok());
    return hits;
  }

  SceneSource city_ = make_city(600, 1);
  SceneGeometry geometry_{city_};
};

bool same(const std::vector<Ray>& a, const std::vector<Ray>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Ray& x, const Ray& y) {
    return x.origin == y.origin && x.direction == y.direction && x.tmin == y.tmin &&
           x.tmax == y.tmax;
  });
}

TEST_F(RayKinds, HaveTheRequestedCountAndAreTheSameEveryTime) {
  for (const char* kind : kNames) {
    const std::vector<Ray> first = rays(kind, 333, 5);
    EXPECT_EQ(first.size(), 333u) << kind;
    tbb::task_arena alone(1);
    EXPECT_TRUE(same(first, alone.execute([&] { return rays(kind, 333, 5); }))) << kind;
    const bool seedless =
        std::string_view(kind) == "overview" || std::string_view(kind) == "shadow";
    EXPECT_EQ(same(first, rays(kind, 333, 6)), seedless) << kind;
  }
}

TEST_F(RayKinds, OverviewLooksAtTheSceneFromOutside) {
  const std::vector<Ray> overview = rays("overview", 64 * 64);
  Vec3d mean{};
  for (const Ray& ray : overview) {
    EXPECT_NEAR(length(ray.origin - geometry_.center()), 1.2 * geometry_.diagonal(), 1e-9);
    EXPECT_NEAR(length(ray.direction), 1, 1e-15);
    mean = mean + ray.direction;
  }
  const Vec3d forward =
      (geometry_.center() - overview[0].origin) * (1 / (1.2 * geometry_.diagonal()));
  EXPECT_GT(dot(mean, forward) / length(mean), 1 - 1e-9);
  // The corner pixel of a 40 degree square lies tan 20 to the side and tan 20 above.
  const double corner = 1 / dot(overview[0].direction, forward);
  EXPECT_NEAR(corner, std::sqrt(1 + 2 * std::pow(std::tan(20 * M_PI / 180) * 63 / 64, 2)), 1e-9);
  // The first 64 rays are one 8x8 tile.
  for (std::size_t i = 0; i < 64; ++i) {
    EXPECT_GT(dot(overview[i].direction, overview[0].direction), 0.99);
  }
}

TEST_F(RayKinds, CloseupSeesFewTriangles) {
  const std::vector<Ray> closeup = rays("closeup", 400);
  std::set<std::pair<std::uint64_t, std::uint32_t>> seen;
  for (const Hit& hit : trace(closeup)) {
    if (hit.state == HitState::kHit) seen.emplace(hit.node, hit.primitive);
  }
  EXPECT_FALSE(seen.empty());
  EXPECT_LE(seen.size() * 100, geometry_.triangles());
}

TEST_F(RayKinds, DiffuseStartsOnTheSurfaceAndLeavesIt) {
  std::set<double> starts;
  for (const Ray& ray : rays("diffuse", 500)) {
    EXPECT_NEAR(length(ray.direction), 1, 1e-14);
    EXPECT_GT(ray.tmin, 0);
    starts.insert(ray.origin.x + 17 * ray.origin.y + 31 * ray.origin.z);
  }
  EXPECT_GT(starts.size(), 490u) << "one bounce a hit";
}

TEST_F(RayKinds, ShadowRaysEndAtOneLightAbove) {
  const std::vector<Ray> shadow = rays("shadow", 500);
  const Vec3d light = shadow[0].origin + shadow[0].direction;
  EXPECT_GT(light.y, geometry_.hi().y);
  for (const Ray& ray : shadow) {
    EXPECT_EQ(ray.tmin, 1e-4);
    EXPECT_EQ(ray.tmax, 1 - 1e-4);
    EXPECT_LT(length(ray.origin + ray.direction - light), 1e-9 * geometry_.diagonal());
  }
}

TEST_F(RayKinds, RandomChordsStartOnTheSphereAndMeetTheBox) {
  for (const Ray& ray : rays("random", 500)) {
    EXPECT_NEAR(length(ray.origin - geometry_.center()), 0.5 * geometry_.diagonal(), 1e-9);
    double enter = 0, leave = accel::geometry::kInfinity;
    for (std::size_t a = 0; a < 3; ++a) {
      const double t0 = (geometry_.lo()[a] - ray.origin[a]) / ray.direction[a];
      const double t1 = (geometry_.hi()[a] - ray.origin[a]) / ray.direction[a];
      enter = std::max(enter, std::min(t0, t1));
      leave = std::min(leave, std::max(t0, t1));
    }
    EXPECT_LE(enter, leave * (1 + 1e-12));
  }
}

TEST(AimedRays, PassThroughVerticesAndEdges) {
  const SceneSource sphere = make_icosphere(3, 100);
  const SceneGeometry geometry(sphere);
  const auto aimed = make_rays(sphere, RayKind::kAimed, 100, 1);
  ASSERT_TRUE(aimed.ok());
  for (const Ray& ray : *aimed) {
    // The smallest distance of the line to any edge.
    double nearest = accel::geometry::kInfinity;
    for (std::uint64_t n = 0; n < geometry.triangles(); ++n) {
      const auto corners = geometry.triangle(n);
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3d edge = corners[(i + 1) % 3] - corners[i];
        const Vec3d common = cross(ray.direction, edge);
        const double away = std::abs(dot(corners[i] - ray.origin, common)) / length(common);
        nearest = std::min(nearest, away);
      }
    }
    EXPECT_LT(nearest, 1e-12);
  }
}

TEST(RayKindErrors, NameTheKindsAndTheReason) {
  const auto unknown = parse_ray_kind("sideways");
  ASSERT_FALSE(unknown.ok());
  EXPECT_EQ(unknown.error().code, Code::kInvalidArgument);
  for (const char* name : kNames) {
    EXPECT_NE(unknown.error().message.find(name), std::string::npos);
  }
  const auto nothing = make_rays(SceneSource{}, RayKind::kRandom, 5, 1);
  ASSERT_FALSE(nothing.ok());
  EXPECT_EQ(nothing.error().code, Code::kFailedPrecondition);
}

// The whole picture, for any size, without duplicate pixels.
TEST(Pinhole, CoversSidesThatAreNotMultiplesOfATile) {
  const std::vector<Ray> rays = pinhole({0, 0, 5}, {0, 0, 0}, 11 * 11);
  std::set<std::pair<long, long>> pixels;
  for (const Ray& ray : rays) {
    const double x = ray.direction.x / -ray.direction.z, y = ray.direction.y / -ray.direction.z;
    pixels.emplace(std::lround(x * 1e6), std::lround(y * 1e6));
  }
  EXPECT_EQ(pixels.size(), 121u);
}

}  // namespace
}  // namespace sightline::bench

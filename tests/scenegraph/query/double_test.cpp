// Cases that need double: distant positions, and transforms that scale, mirror and nearly flatten.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <iostream>

#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/put_node.h"
#include "tests/support/brute_force.h"
#include "tests/support/compare_hits.h"
#include "tests/support/millimetres.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::dot;
using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::length;
using accel::geometry::Ray;
using accel::geometry::Vec3d;

constexpr double kTenthOfAMillimetre = 1e-4;
constexpr double kNudge = 1e-7;
constexpr std::size_t kRays = 4000;

model::PutNode put(model::NodeRef node, model::NodeRef parent,
                   std::shared_ptr<const model::Mesh> mesh, const model::Affine& where) {
  model::PutNode p;
  p.node = node;
  p.parent = parent;
  p.name = "n" + std::to_string(-node);
  p.mesh = std::move(mesh);
  p.mesh_digest = p.mesh ? "digest" : "";
  p.parent_from_local = where;
  return p;
}

std::shared_ptr<const revision::Snapshot> scene_of(const std::vector<model::Update>& updates) {
  Scene scene;
  const auto applied = scene.apply(updates);
  EXPECT_TRUE(applied) << applied.error().message;
  return scene.snapshot();
}

std::vector<Hit> cast(const revision::Snapshot& snapshot, std::span<const Ray> rays) {
  std::vector<Hit> hits(rays.size());
  EXPECT_TRUE(trace(snapshot, rays, hits, {}));
  return hits;
}

Hit cast(const revision::Snapshot& snapshot, const Ray& ray) {
  return cast(snapshot, {&ray, 1})[0];
}

model::Affine scaling(double x, double y, double z) {
  return {{x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0}};
}
model::Affine translation(const Vec3d& by) {
  return {{1, 0, 0, by.x, 0, 1, 0, by.y, 0, 0, 1, by.z}};
}

/// Rotates about z and then about x, by the angle with this sine and cosine.
model::Affine turning(double sine, double cosine) {
  const model::Affine about_z{{cosine, -sine, 0, 0, sine, cosine, 0, 0, 0, 0, 1, 0}};
  const model::Affine about_x{{1, 0, 0, 0, 0, cosine, -sine, 0, 0, sine, cosine, 0}};
  return compose(about_x, about_z);
}

std::vector<Ray> moved(std::vector<Ray> rays, const Vec3d& by) {
  for (Ray& ray : rays) ray.origin = ray.origin + by;
  return rays;
}

TEST(Millimetres, AreEqualToTheLastBitForExactRays) {
  const auto plate = tests::mesh_of(tests::ridged_plate());
  const Vec3d far{1e7, -1e7, 1e7};
  const auto here = scene_of({put(-1, 0, plate, model::Affine{})});
  const auto there = scene_of({put(-1, 0, plate, translation(far))});
  const std::vector<Ray> rays = tests::kilometre_rays(kRays, 1, 20);
  const std::vector<Hit> a = cast(*here, rays), b = cast(*there, moved(rays, far));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(a[i].state, HitState::kHit) << "ray " << i;
    ASSERT_EQ(std::memcmp(&a[i].t, &b[i].t, sizeof a[i].t), 0) << "ray " << i;
    ASSERT_EQ(a[i].primitive, b[i].primitive) << "ray " << i;
    ASSERT_EQ(a[i].normal, b[i].normal) << "ray " << i;
  }
}

TEST(Millimetres, AreHitTenThousandKilometersAwayAsAtTheOrigin) {
  const auto plate = tests::mesh_of(tests::ridged_plate());
  const Vec3d far{1e7 + 1.0 / 3, -1e7 - 0.7, 1e7 + 0.1};
  // As a root, and rotated under a parent that moves it far away.
  const model::Affine turned = turning(0.6, 0.8);
  const auto free_here = scene_of({put(-1, 0, plate, model::Affine{})});
  const auto free_there = scene_of({put(-1, 0, plate, translation(far))});
  const auto turned_here = scene_of({put(-1, 0, plate, turned)});
  const auto turned_there =
      scene_of({put(-1, 0, nullptr, translation(far)), put(-2, -1, plate, turned)});
  const std::vector<Ray> rays = tests::with_nudges(tests::kilometre_rays(kRays, 2, 40), kNudge);
  std::vector<Ray> turned_rays = rays;
  for (Ray& ray : turned_rays) ray = {turned.point(ray.origin), turned.direction(ray.direction)};

  for (const auto& d :
       {tests::displacement(cast(*free_here, rays), cast(*free_there, moved(rays, far))),
        tests::displacement(cast(*turned_here, turned_rays),
                            cast(*turned_there, moved(turned_rays, far)))}) {
    EXPECT_EQ(d.missed, 0u) << d.report();
    EXPECT_EQ(d.others, 0u) << d.report();
    EXPECT_LT(d.largest_t_error, kTenthOfAMillimetre) << d.report();
    EXPECT_GT(d.steady, d.rays * 9 / 10) << d.report();
    std::cout << d.report() << "\n";
  }
}

TEST(Transforms, TIsInUnitsOfTheRaysDirectionForAnyScale) {
  const auto cube = tests::mesh_of(tests::cube());
  for (const model::Affine& scale :
       {scaling(1, 1, 1), scaling(1024, 0x1p-10, 1), scaling(3, 7, 0.1), scaling(1e5, 1e-5, 1)}) {
    const auto snapshot = scene_of({put(-1, 0, cube, scale)});
    for (const double speed : {1.0, 0.25, 100.0}) {
      // Down onto the top of the cube, whose height is the scale of z.
      const double top = scale.m[10];
      const Hit hit =
          cast(*snapshot, Ray{{0.25 * scale.m[0], 0.125 * scale.m[5], 50}, {0, 0, -speed}});
      ASSERT_EQ(hit.state, HitState::kHit);
      EXPECT_NEAR(hit.t, (50 - top) / speed, 1e-12 * 50 / speed);
      EXPECT_EQ(hit.normal, (accel::geometry::Vec3f{0, 0, 1}));
    }
  }
}

TEST(Transforms, NormalsArePerpendicularToScaledSurfaces) {
  const auto sphere = tests::mesh_of(tests::icosphere(3));
  tests::Random random(3);
  for (const model::Affine& shape :
       {scaling(1, 20, 0.05), scaling(-1, 20, 0.05), scaling(-3, -2, -0.5),
        compose(turning(0.6, 0.8), scaling(5, 0.2, 1))}) {
    const auto snapshot = scene_of({put(-1, 0, sphere, shape)});
    const tests::TestMesh mesh = tests::icosphere(3);
    for (int i = 0; i < 300; ++i) {
      const Vec3d from = random.direction() * 3.0;
      const Vec3d at = random.direction() * 0.5;
      const Hit hit = cast(*snapshot, Ray{shape.point(from), shape.direction(at - from)});
      ASSERT_EQ(hit.state, HitState::kHit);
      // Computed from the triangle's corners in world space.
      const accel::geometry::Face& f = mesh.faces[hit.primitive];
      const auto corner = [&](std::size_t k) { return shape.point(Vec3d(mesh.vertices[f[k]])); };
      const Vec3d n = cross(corner(1) - corner(0), corner(2) - corner(0));
      EXPECT_NEAR(std::fabs(dot(n * (1 / length(n)), Vec3d(hit.normal))), 1, 1e-6);
      // Outward, also where the transform mirrors.
      EXPECT_LT(dot(Vec3d(hit.normal), shape.direction(at - from)), 0);
    }
  }
}

TEST(Transforms, NearlySingularTransformsAgreeWithTheOracleUpToTheLimit) {
  const auto sphere = tests::mesh_of(tests::icosphere(3));
  for (const double thin : {1e-3, 1e-6, 1e-9}) {
    const model::Affine flat = compose(turning(0.6, 0.8), scaling(1, 1, thin));
    const auto snapshot = scene_of({put(-1, 0, sphere, flat)});
    tests::Random random(4);
    std::vector<Ray> rays(500);
    for (Ray& ray : rays) {
      const Vec3d from = random.direction() * 3.0, at = random.direction() * 0.5;
      ray = Ray{flat.point(from), flat.direction(at - from)};
    }
    const auto compared = tests::compare(rays, cast(*snapshot, rays), tests::BruteForce(snapshot));
    EXPECT_EQ(compared.mismatches, 0u) << thin << ": " << compared.report();
    EXPECT_EQ(compared.hits, rays.size()) << thin;
  }
}

TEST(Transforms, BeyondTheLimitAreStoredAndNotHit) {
  const auto sphere = tests::mesh_of(tests::icosphere(3));
  for (const model::Affine& matrix :
       {scaling(1, 0, 1), scaling(1, 1, 1e-12), scaling(0, 0, 0), scaling(1e-200, 1e-200, 1),
        scaling(1e120, 1e120, 1e120), compose(turning(0.6, 0.8), scaling(1, -0.0, 2)),
        model::Affine{{1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0}}}) {
    const auto snapshot = scene_of({put(-1, 0, sphere, matrix)});
    EXPECT_EQ(snapshot->find(1)->parent_from_local, matrix);
    EXPECT_EQ(cast(*snapshot, Ray{{0.1, 0.2, 5}, {0, 0, -1}}).state, HitState::kMiss);
    EXPECT_EQ(revision::summarize(*snapshot).instances, 1u);
    EXPECT_TRUE(snapshot->bounds().empty());
  }
  EXPECT_EQ(
      cast(*scene_of({put(-1, 0, sphere, scaling(1, 1, 1e-11))}), Ray{{0.1, 0.2, 5}, {0, 0, -1}})
          .state,
      HitState::kHit);
}

}  // namespace
}  // namespace sightline::scenegraph::query

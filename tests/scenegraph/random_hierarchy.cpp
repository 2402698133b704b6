// Making hierarchies.
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/scenegraph/put_node.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace sightline::tests {

using accel::geometry::Vec3d;
using scenegraph::Scene;
using scenegraph::model::Affine;
using scenegraph::model::Mesh;
using scenegraph::model::NodeRef;
using scenegraph::model::PutNode;
using scenegraph::model::Update;
using scenegraph::revision::Snapshot;

namespace {

Affine random_turn(Random& random) {
  const Vec3d x = random.direction();
  Vec3d y = cross(x, random.direction());
  y = y * (1 / std::sqrt(dot(y, y)));
  const Vec3d z = cross(x, y);
  return Affine{{x.x, y.x, z.x, 0, x.y, y.y, z.y, 0, x.z, y.z, z.z, 0}};
}

Affine random_shear(Random& random) {
  for (;;) {
    Affine a;
    for (double& m : a.m) m = random.uniform(-1, 1);
    const auto back = inverse(a);
    if (back && condition(a, *back) < 50) return a;
  }
}

/// Far from the limits of Scene::apply.
bool is_moderate(const Affine& a) {
  const auto back = inverse(a);
  return back && condition(a, *back) < 1e8;
}

}  // namespace

Affine random_frame(Random& random, Frames frames, double reach) {
  Affine a = frames == Frames::kSheared ? random_shear(random) : random_turn(random);
  if (frames == Frames::kFar) reach += random.below(2) == 0 ? reach * 1e6 : 0;
  for (const std::size_t i : {3u, 7u, 11u}) a.m[i] = random.uniform(-reach, reach);
  if (frames == Frames::kFlat && random.below(4) == 0) {
    for (const std::size_t i : {8u, 9u, 10u}) a.m[i] *= 1e-3;
  }
  return a;
}

std::shared_ptr<const Mesh> some_mesh(std::uint64_t index) {
  const auto not_finite = [] {
    TestMesh mesh = single_triangle();
    for (accel::geometry::Vec3f& v : mesh.vertices) v.x = std::numeric_limits<float>::quiet_NaN();
    return mesh;
  };
  static const std::shared_ptr<const Mesh> kMeshes[] = {
      mesh_of(icosphere(1)), mesh_of(single_triangle()),
      mesh_of(cube()),       mesh_of(random_soup(60, 0.3, 3)),
      mesh_of(TestMesh{}),   mesh_of(not_finite())};
  return kMeshes[index % std::size(kMeshes)];
}

std::vector<Update> random_hierarchy(int nodes, Frames frames, std::uint64_t seed) {
  Random random(seed);
  std::vector<Update> updates;
  std::vector<int> depths{0};
  std::vector<Affine> worlds(1);
  for (int i = 1; i <= nodes; ++i) {
    PutNode put;
    put.node = -i;
    const auto any = static_cast<std::size_t>(random.below(static_cast<std::uint64_t>(i)));
    const std::size_t parent =
        random.below(3) == 0 && i > 1 ? static_cast<std::size_t>(i) - 1 : any;
    if (depths[parent] < 12) put.parent = -static_cast<NodeRef>(parent);
    depths.push_back(put.parent == 0 ? 1 : depths[parent] + 1);
    put.parent_from_local = random_frame(random, frames);
    const Affine& above = worlds[static_cast<std::size_t>(-put.parent)];
    if (!is_moderate(compose(above, put.parent_from_local)))
      put.parent_from_local = random_frame(random, Frames::kRigid);
    worlds.push_back(compose(above, put.parent_from_local));
    if (random.below(2) == 0) {
      put.mesh = some_mesh(random.next());
      put.mesh_digest = "digest";
      put.mobility = random.below(3) == 0 ? scenegraph::model::Mobility::kRigid
                                          : scenegraph::model::Mobility::kStatic;
    }
    updates.push_back(put);
  }
  return updates;
}

std::shared_ptr<const Snapshot> snapshot_of(const std::vector<Update>& updates) {
  Scene scene;
  const auto applied = scene.apply(updates);
  EXPECT_TRUE(applied) << applied.error().message;
  return scene.snapshot();
}

std::vector<accel::geometry::Ray> rays_through(const Snapshot& snapshot, std::size_t count,
                                               std::uint64_t seed) {
  Random random(seed);
  const scenegraph::revision::WorldBounds& b = snapshot.bounds();
  std::vector<const scenegraph::model::Node*> targets;
  snapshot.nodes().for_each(
      [&](std::uint64_t, const std::shared_ptr<const scenegraph::model::Node>& n) {
        if (n->mesh != nullptr && !n->mesh->bounds().empty()) targets.push_back(n.get());
      });
  const auto within = [&](const Vec3d& lo, const Vec3d& hi) {
    return Vec3d{random.uniform(lo.x, hi.x), random.uniform(lo.y, hi.y),
                 random.uniform(lo.z, hi.z)};
  };
  std::vector<accel::geometry::Ray> rays(count);
  for (accel::geometry::Ray& ray : rays) {
    if (random.below(2) == 0) {
      ray.origin = within(b.lo, b.hi);
      ray.direction = within(b.lo, b.hi) - ray.origin;
      continue;
    }
    const scenegraph::model::Node& target = *targets[random.below(targets.size())];
    const accel::geometry::Aabb& box = target.mesh->bounds();
    const Vec3d at =
        world_from_local(snapshot.hierarchy(), target).point(within(Vec3d(box.lo), Vec3d(box.hi)));
    ray.origin = at + random.direction() * random.uniform(0.1, 20);
    ray.direction = at - ray.origin;
  }
  return rays;
}

std::shared_ptr<const Snapshot> tiled_plane(std::size_t leaves, std::size_t fan) {
  const auto square = mesh_of(planar_sheet(1));
  std::vector<Update> updates;
  const auto put = [&](NodeRef parent, double x, double y, bool mesh) {
    PutNode node;
    node.node = -static_cast<NodeRef>(updates.size()) - 1;
    node.parent = parent;
    node.parent_from_local.m[3] = x;
    node.parent_from_local.m[7] = y;
    if (mesh) node.mesh = square;
    updates.push_back(node);
    return node.node;
  };
  std::size_t side = 1;
  while (side * side < leaves) side *= 2;
  // Splits into halves along x and y alternately, so that a subtree is a rectangle.
  const std::function<void(NodeRef, std::size_t, std::size_t, std::size_t, std::size_t, int)>
      split = [&](NodeRef parent, std::size_t x, std::size_t y, std::size_t count,
                  std::size_t parts, int axis) {
        if (count == 1) {
          put(parent, static_cast<double>(x), static_cast<double>(y), true);
          return;
        }
        if (parts == 1) {
          parent = put(parent, 0, 0, false);
          parts = fan;
        }
        std::size_t wide = 1, high = 1;
        for (std::size_t n = count, a = static_cast<std::size_t>(axis); n > 1; n /= 2, ++a)
          (a % 2 == 0 ? wide : high) *= 2;
        const std::size_t step = axis % 2 == 0 ? wide / 2 : high / 2;
        const std::size_t half = parts == 0 ? 0 : parts / 2;
        split(parent, x, y, count / 2, half, axis + 1);
        split(parent, x + (axis % 2 == 0 ? step : 0), y + (axis % 2 == 0 ? 0 : step), count / 2,
              half, axis + 1);
      };
  split(put(0, 0, 0, false), 0, 0, leaves, fan, 0);
  return snapshot_of(updates);
}

}  // namespace sightline::tests

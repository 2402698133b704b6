#include "scenegraph/query/surface.h"

#include <cmath>
#include <optional>

#include "accel/geometry/closest.h"
#include "accel/geometry/intersect.h"

namespace sightline::scenegraph::query {

namespace {

using accel::geometry::Vec3d, accel::geometry::Vec3f;

/// The corners of a face. They have no negative zeros, as in blocks, since signs of zeros are seen
/// in normals.
struct Corners {
  Vec3f a, b, c;

  Corners(const model::Mesh& of, std::uint32_t face) {
    const accel::geometry::MeshView mesh = of.view();
    const accel::geometry::Face& f = mesh.faces[face];
    const Vec3f zero{0, 0, 0};
    a = mesh.vertices[f[0]] + zero;
    b = mesh.vertices[f[1]] + zero;
    c = mesh.vertices[f[2]] + zero;
  }
};

void set_normal(const instances::Instance& instance, const Corners& of, accel::geometry::Hit& hit) {
  // The inverse transpose keeps the normal on its side of the surface, also where space is
  // mirrored.
  const Vec3d normal = instance.local_from_world.transposed(
      accel::geometry::cross(Vec3d(of.b) - Vec3d(of.a), Vec3d(of.c) - Vec3d(of.a)));
  const double size = length(normal);
  if (size != 0 && std::isfinite(size)) hit.normal = Vec3f(normal * (1 / size));
}

}  // namespace

void set_surface(const instances::Instance& instance, const accel::geometry::Ray& ray,
                 accel::geometry::Hit& hit) {
  const Corners corners(*instance.mesh, hit.primitive);
  const std::optional<accel::geometry::LocalRay> local =
      accel::geometry::make_local_ray(instance.local_from_world.point(ray.origin),
                                      instance.local_from_world.direction(ray.direction));
  const accel::geometry::Barycentric weights =
      accel::geometry::barycentric(*local, hit.t / local->unit, corners.a, corners.b, corners.c);
  hit.u = static_cast<float>(weights.u);
  hit.v = static_cast<float>(weights.v);
  set_normal(instance, corners, hit);
}

void set_surface_of_point(const instances::Instance& instance,
                          const model::Affine& world_from_local, const accel::geometry::Ray& ray,
                          accel::geometry::Hit& hit) {
  const Corners corners(*instance.mesh, hit.primitive);
  const accel::geometry::ClosestPoint nearest = accel::geometry::closest_point(
      ray.origin, world_from_local.m, corners.a, corners.b, corners.c);
  hit.u = static_cast<float>(nearest.u);
  hit.v = static_cast<float>(nearest.v);
  set_normal(instance, corners, hit);
}

void set_surface(const instances::OpenTrees& trees, std::size_t instance, bool points,
                 const accel::geometry::Ray& ray, accel::geometry::Hit& hit) {
  if (points)
    return set_surface_of_point(trees[instance], trees.world_from_local(instance), ray, hit);
  set_surface(trees[instance], ray, hit);
}

Vec3d nearest_point(const revision::Snapshot& snapshot, model::NodeId id, std::uint32_t primitive,
                    const Vec3d& point) {
  const model::Node& node = *snapshot.find(id);
  const Corners corners(*node.mesh, primitive);
  const model::Affine world = hierarchy::world_from_local(snapshot.hierarchy(), node);
  return accel::geometry::closest_point(point, world.m, corners.a, corners.b, corners.c).position;
}

accel::geometry::Hit hit_of(const accel::wide::ListedHit& listed) {
  accel::geometry::Hit hit;
  hit.state = accel::geometry::HitState::kHit;
  hit.t = listed.t;
  hit.node = listed.node;
  hit.primitive = listed.primitive;
  return hit;
}

}  // namespace sightline::scenegraph::query

#include "scenegraph/query/surface.h"

#include <cmath>
#include <optional>

#include "accel/geometry/intersect.h"

namespace sightline::scenegraph::query {

void set_surface(const instances::Instance& instance, const accel::geometry::Ray& ray,
                 accel::geometry::Hit& hit) {
  using accel::geometry::Vec3d, accel::geometry::Vec3f;
  const accel::geometry::MeshView mesh = instance.mesh->view();
  const accel::geometry::Face& f = mesh.faces[hit.primitive];
  // Vertices have no negative zeros, as in blocks, since signs of zeros are seen in normals.
  const Vec3f zero{0, 0, 0};
  const Vec3f a = mesh.vertices[f[0]] + zero, b = mesh.vertices[f[1]] + zero,
              c = mesh.vertices[f[2]] + zero;
  const std::optional<accel::geometry::LocalRay> local =
      accel::geometry::make_local_ray(instance.local_from_world.point(ray.origin),
                                      instance.local_from_world.direction(ray.direction));
  const accel::geometry::Barycentric weights =
      accel::geometry::barycentric(*local, hit.t / local->unit, a, b, c);
  hit.u = static_cast<float>(weights.u);
  hit.v = static_cast<float>(weights.v);
  // The inverse transpose keeps the normal on its side of the surface, also where space is
  // mirrored.
  const Vec3d normal = instance.local_from_world.transposed(
      accel::geometry::cross(Vec3d(b) - Vec3d(a), Vec3d(c) - Vec3d(a)));
  const double size = length(normal);
  if (size != 0 && std::isfinite(size)) hit.normal = Vec3f(normal * (1 / size));
}

accel::geometry::Hit hit_of(const accel::wide::ListedHit& listed, const instances::OpenTrees& trees,
                            const accel::geometry::Ray& ray, bool surface) {
  accel::geometry::Hit hit;
  hit.state = accel::geometry::HitState::kHit;
  hit.t = listed.t;
  hit.node = listed.node;
  hit.primitive = listed.primitive;
  if (surface) set_surface(trees[listed.instance], ray, hit);
  return hit;
}

}  // namespace sightline::scenegraph::query

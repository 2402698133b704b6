// Rays of a remote measurement.
#include "tests/bench/remote/remote_rays.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "proto/rays/generated_rays.h"
#include "tests/bench/scenes/scene_geometry.h"

namespace sightline::bench {
namespace {

using accel::geometry::Ray;
using accel::geometry::Vec3d;
using proto::rays::Vector;

constexpr double kDegrees = 40;
constexpr double kDistance = 1.2;  // in diagonals

void append(const Vec3d& v, std::vector<float>& column) {
  for (const double number : {v.x, v.y, v.z}) column.push_back(static_cast<float>(number));
}

Vec3d rounded(const Vec3d& v) {
  return {static_cast<double>(static_cast<float>(v.x)),
          static_cast<double>(static_cast<float>(v.y)),
          static_cast<double>(static_cast<float>(v.z))};
}

Vec3d unit(const Vec3d& v) { return v * (1 / length(v)); }

Vector vector_of(const Vec3d& v) { return {v.x, v.y, v.z}; }

}  // namespace

RemoteRays RemoteRays::of(std::span<const Ray> rays) {
  RemoteRays remote;
  const bool limited = std::any_of(rays.begin(), rays.end(), [](const Ray& ray) {
    return ray.tmin != 0 || ray.tmax != accel::geometry::kInfinity;
  });
  for (Ray ray : rays) {
    append(ray.origin, remote.origins);
    append(ray.direction, remote.directions);
    if (limited) {
      remote.tmin.push_back(static_cast<float>(ray.tmin));
      remote.tmax.push_back(static_cast<float>(ray.tmax));
      ray.tmin = static_cast<double>(remote.tmin.back());
      ray.tmax = static_cast<double>(remote.tmax.back());
    }
    ray.origin = rounded(ray.origin);
    ray.direction = rounded(ray.direction);
    remote.in_process.push_back(ray);
  }
  return remote;
}

RemoteRays RemoteRays::picture(const SceneSource& scene, std::size_t count) {
  const SceneGeometry geometry(scene);
  const Vec3d from = unit(Vec3d{1, 0.7, 0.5});
  const Vec3d right = unit(cross(Vec3d{} - from, Vec3d{0, 1, 0}));
  const Vec3d up = cross(right, Vec3d{} - from);
  const double half = std::tan(kDegrees * std::numbers::pi / 360);
  proto::rays::Pinhole pinhole;
  pinhole.eye = vector_of(geometry.center() + from * (kDistance * geometry.diagonal()));
  pinhole.corner = vector_of(up * half - right * half - from);
  pinhole.across = vector_of(right * (2 * half));
  pinhole.down = vector_of(up * (-2 * half));
  pinhole.width = pinhole.height =
      static_cast<std::uint32_t>(std::sqrt(static_cast<double>(count)));
  pinhole.tiled = true;
  RemoteRays remote;
  remote.generator.rays = pinhole;
  remote.generated = true;
  proto::rays::GeneratedRays rays;
  rays.begin(remote.generator);
  remote.in_process.resize(rays.size());
  rays.make(0, rays.size(), [&](std::size_t i, const Vector& o, const Vector& d) {
    remote.in_process[i].origin = {o[0], o[1], o[2]};
    remote.in_process[i].direction = {d[0], d[1], d[2]};
  });
  return remote;
}

client::RayColumns<const float> RemoteRays::columns() const {
  return {origins, directions, tmin, tmax, {}};
}

}  // namespace sightline::bench

// The scenes and rays that show whether a method loses hits.
#include "tests/bench/verbs/robust_family.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include "tests/bench/scenes/generators.h"
#include "tests/bench/scenes/load_scene.h"
#include "tests/bench/scenes/scene_geometry.h"
#include "tests/support/random.h"

namespace sightline::bench {

using accel::geometry::Ray;
using accel::geometry::Vec3d;
using tests::Random;

namespace {

constexpr std::string_view kBoxed = "mesh-in-box";

// At this distance a sphere in float has only a few distinct vertices, and a ray near them meets
// most of its triangles.
constexpr double kCollapsedShare = 0.02;

struct Offset {
  std::string_view name;
  double offset;
};
constexpr std::array<Offset, 4> kSpheres{
    {{"icosphere-0", 0}, {"icosphere-1e3", 1e3}, {"icosphere-1e5", 1e5}, {"icosphere-1e7", 1e7}}};

constexpr std::array<std::string_view, 4> kRayKinds{"vertices", "edges", "random", "axis"};

std::string mesh_to_box(const std::string& given) {
  if (!given.empty()) return given;
  const char* folder = std::getenv("SIGHTLINE_SCENES");
  return folder == nullptr ? "" : (std::filesystem::path(folder) / "bunny.ply").string();
}

Vec3d unit(const Vec3d& v) { return v * (1 / length(v)); }

// The vertices and edges that rays are aimed at.
class RayMaker {
 public:
  RayMaker(const RobustFamily& family, std::uint64_t seed)
      : geometry_(family.scene), sphere_(family.sphere), seed_(seed) {
    // The last twelve faces are the box's: few, but every ray that leaks out passes through them.
    if (!sphere_) box_first_ = geometry_.triangles() - 12;
  }

  Ray make(std::string_view kind, std::size_t i) const {
    Random random(seed_, i);
    const bool outside = sphere_ && i % 2 == 0;
    if (kind == "axis") return along_axis(random, outside, i / 2 % 2 == 0);
    const Vec3d target = kind == "vertices" ? vertex(random)
                         : kind == "edges"  ? edge_point(random)
                                            : box_point(random, 1);
    Ray ray;
    ray.origin = outside ? geometry_.center() + random.direction() * geometry_.diagonal()
                         : inner_point(random);
    ray.direction = unit(target - ray.origin);
    return ray;
  }

 private:
  // Every eighth ray aims at the box around the scene, if there is one.
  SceneGeometry::Corners triangle(Random& random) const {
    if (!sphere_ && random.below(8) == 0) {
      return geometry_.triangle(box_first_ + random.below(geometry_.triangles() - box_first_));
    }
    return geometry_.triangle(random.below(sphere_ ? geometry_.triangles() : box_first_));
  }

  Vec3d vertex(Random& random) const {
    const auto corners = triangle(random);
    return corners[random.below(3)];
  }

  // Not at the box: a ray along its wall would not be inside.
  Vec3d inner_vertex(Random& random) const {
    const std::uint64_t inner = sphere_ ? geometry_.triangles() : box_first_;
    return geometry_.triangle(random.below(inner))[random.below(3)];
  }

  Vec3d edge_point(Random& random) const {
    const auto corners = triangle(random);
    const std::size_t corner = random.below(3);
    const Vec3d& from = corners[corner];
    return from + (corners[(corner + 1) % 3] - from) * random.uniform();
  }

  Vec3d box_point(Random& random, double share) const {
    const Vec3d half = (geometry_.hi() - geometry_.lo()) * (0.5 * share);
    const Vec3d center = geometry_.center();
    return {center.x + half.x * random.uniform(-1, 1), center.y + half.y * random.uniform(-1, 1),
            center.z + half.z * random.uniform(-1, 1)};
  }

  // Inside the sphere, or inside the box.
  Vec3d inner_point(Random& random) const { return box_point(random, sphere_ ? 0.5 : 0.95); }

  Ray along_axis(Random& random, bool outside, bool through_vertex) const {
    const Vec3d middle = geometry_.center();
    const double sign = random.below(2) == 0 ? 1 : -1;
    Vec3d at = through_vertex ? inner_vertex(random)
               : outside      ? box_point(random, 0.95)
                              : inner_point(random);
    std::size_t axis = random.below(3);
    if (outside) {
      at[axis] = middle[axis] - sign * geometry_.diagonal();
    } else if (through_vertex) {
      // Along the axis of its largest coordinate, to well inside.
      const Vec3d from_middle = at - middle;
      for (std::size_t a = 0; a < 3; ++a) {
        if (std::abs(from_middle[a]) > std::abs(from_middle[axis])) axis = a;
      }
      at[axis] = middle[axis] + from_middle[axis] * random.uniform(-0.9, 0.9);
    }
    Ray ray;
    ray.origin = at;
    ray.direction = {};
    ray.direction[axis] = sign;
    return ray;
  }

  SceneGeometry geometry_;
  bool sphere_;
  std::uint64_t seed_;
  std::uint64_t box_first_ = 0;
};

}  // namespace

std::vector<std::string_view> robust_family_names() {
  std::vector<std::string_view> names;
  names.reserve(kSpheres.size() + 1);
  for (const Offset& sphere : kSpheres) names.push_back(sphere.name);
  names.push_back(kBoxed);
  return names;
}

std::vector<std::string_view> robust_ray_kinds() { return {kRayKinds.begin(), kRayKinds.end()}; }

Result<std::vector<RobustFamily>> make_robust_families(const std::string& name, int level,
                                                       const std::string& mesh) {
  std::vector<RobustFamily> families;
  for (const Offset& sphere : kSpheres) {
    if (!sphere.name.starts_with(name)) continue;
    families.push_back({std::string(sphere.name), make_icosphere(level, sphere.offset), true,
                        sphere.offset < 1e6 ? 1 : kCollapsedShare});
  }
  const std::string file = mesh_to_box(mesh);
  if (kBoxed.starts_with(name) && !file.empty()) {
    auto scene = load_scene(file);
    if (!scene.ok()) return scene.error();
    families.push_back({std::string(kBoxed), make_boxed(std::move(scene).value())});
  } else if (name.empty()) {
    fmt::print(stderr,
               "sightline-bench: no rows for {}: give --scene FILE, or set SIGHTLINE_SCENES to a "
               "folder with bunny.ply\n",
               kBoxed);
  }
  if (!families.empty()) return families;
  if (kBoxed.starts_with(name)) {
    return Error{Code::kInvalidArgument,
                 fmt::format("family {} needs --scene FILE, or SIGHTLINE_SCENES set to a folder "
                             "with bunny.ply",
                             kBoxed),
                 "COMMAND_LINE"};
  }
  std::string known;
  for (const std::string_view family : robust_family_names()) known += fmt::format(" {}", family);
  return Error{Code::kInvalidArgument, fmt::format("no family \"{}\"; there are:{}", name, known),
               "COMMAND_LINE"};
}

std::vector<Ray> make_robust_rays(const RobustFamily& family, std::string_view kind,
                                  std::size_t count, std::uint64_t seed) {
  const RayMaker maker(family, seed);
  std::vector<Ray> rays(count);
  for (std::size_t i = 0; i < count; ++i) rays[i] = maker.make(kind, i);
  return rays;
}

SphereTruth::SphereTruth(const SceneSource& scene) {
  const SceneGeometry geometry(scene);
  center_ = geometry.center();
  inner_ = std::numeric_limits<double>::infinity();
  outer_ = 0;
  for (std::uint64_t n = 0; n < geometry.triangles(); ++n) {
    const auto [a, b, c] = geometry.triangle(n);
    const Vec3d normal = cross(b - a, c - a);
    inner_ = std::min(inner_, std::abs(dot(normal, a - center_)) / length(normal));
    for (const Vec3d& corner : {a, b, c}) outer_ = std::max(outer_, length(corner - center_));
  }
  // World coordinates of the mesh are rounded by up to an ulp of the offset.
  const double slack = 1e-9 + 0x1p-50 * length(center_);
  inner_ -= slack;
  outer_ += slack;
}

CrossingBounds SphereTruth::bounds(const Ray& ray) const {
  const Vec3d o = ray.origin - center_;
  const double from_center = length(o), speed = length(ray.direction);
  if (from_center < inner_) return {1, 1};
  if (from_center < outer_) return {0, 2};
  const double aside = length(cross(o, ray.direction)) / speed;
  const bool away = dot(o, ray.direction) >= 0;
  if (away || aside > outer_) return {0, 0};
  return aside < inner_ ? CrossingBounds{2, 2} : CrossingBounds{0, 2, true};
}

}  // namespace sightline::bench

// Points are found by casting a picture or chords. Rays spread between neighbouring points.
#include "client/load/ray_kinds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "client/cli/picture/camera.h"
#include "client/load/coverage.h"

namespace sightline::client::load {
namespace {

using Vec = std::array<double, 3>;
using cli::picture::add;
using cli::picture::cross;
using cli::picture::dot;
using cli::picture::length;
using cli::picture::scale;
using cli::picture::sub;
using cli::picture::unit;
using Engine = std::mt19937_64;

constexpr cli::PictureSize kProbe{128, 128};
constexpr std::size_t kChords = 65'536;

// The standard library's distributions differ between implementations.
double uniform(Engine& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

Vec in_ball(Engine& random) {
  for (;;) {
    const Vec p{2 * uniform(random) - 1, 2 * uniform(random) - 1, 2 * uniform(random) - 1};
    const double square = dot(p, p);
    if (square > 1e-6 && square <= 1) return p;
  }
}

// A random direction, by the cosine to the normal.
Vec bounce(const Vec& normal, Engine& random) {
  for (;;) {
    const Vec direction = add(normal, unit(in_ball(random)));
    if (length(direction) > 1e-3) return unit(direction);
  }
}

struct Extent {
  explicit Extent(const std::array<double, 6>& bounds)
      : low{bounds[0], bounds[1], bounds[2]},
        high{bounds[3], bounds[4], bounds[5]},
        center(scale(add(low, high), 0.5)),
        diagonal(length(sub(high, low))) {}
  Vec low, high, center;
  double diagonal;

  // Whether float32 tells the points of the scene from each other.
  bool fits_floats() const {
    constexpr double kRange = 4096;
    double farthest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
      farthest = std::max({farthest, std::abs(low[axis]), std::abs(high[axis])});
    return farthest <= kRange * diagonal;
  }
};

Result<std::vector<Ray>> picture_rays(const SceneInfo& scene,
                                      const cli::picture::CameraRequest& view) {
  const auto camera = cli::picture::make_camera(view, scene, kProbe);
  if (!camera) return Error{Code::kFailedPrecondition, "the scene has no extent", "NO_EXTENT"};
  const auto made = make_rays(cli::picture::rays_of(*camera, kProbe));
  if (!made) return made.error();
  std::vector<Ray> rays(made->origins.size() / 3);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    std::copy_n(made->origins.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                rays[i].origin.begin());
    std::copy_n(made->directions.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                rays[i].direction.begin());
  }
  return rays;
}

std::vector<Ray> chords(const Extent& extent, Engine& random) {
  std::vector<Ray> rays;
  while (rays.size() < kChords) {
    const Vec from = unit(in_ball(random)), to = unit(in_ball(random));
    if (length(sub(to, from)) < 1e-3) continue;
    rays.push_back({.origin = add(extent.center, scale(from, 0.5 * extent.diagonal)),
                    .direction = unit(sub(to, from))});
  }
  return rays;
}

Result<std::vector<Aim>> aims_of(std::span<const Ray> rays, const Caster& cast) {
  const auto found = cast(rays);
  if (!found) return found.error();
  std::vector<Aim> aims;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Found& hit = (*found)[i];
    if (!std::isfinite(hit.t)) continue;
    const Vec& direction = rays[i].direction;
    const Vec normal = dot(hit.normal, direction) > 0 ? scale(hit.normal, -1) : hit.normal;
    aims.push_back({add(rays[i].origin, scale(direction, hit.t)), normal, rays[i].origin});
  }
  if (aims.size() < RayMaker::kFewestAims) {
    return Error{Code::kFailedPrecondition,
                 fmt::format("only {} of {} rays hit the scene", aims.size(), rays.size()),
                 "TOO_FEW_HITS"};
  }
  return aims;
}

Result<std::vector<Aim>> aims_of_picture(const SceneInfo& scene, const Caster& cast,
                                         const cli::picture::CameraRequest& view = {}) {
  const auto rays = picture_rays(scene, view);
  if (!rays) return rays.error();
  return aims_of(*rays, cast);
}

Result<std::vector<Aim>> find_aims(RayKind kind, const SceneInfo& scene, const Extent& extent,
                                   const Caster& cast, Engine& random) {
  if (kind == RayKind::kRandom) return aims_of(chords(extent, random), cast);
  auto seen = aims_of_picture(scene, cast);
  if (!seen || kind != RayKind::kCloseup) return seen;
  const Aim& chosen = (*seen)[random() % seen->size()];
  const Vec eye = add(chosen.point, scale(chosen.normal, 0.05 * extent.diagonal));
  return aims_of_picture(scene, cast, {.eye = eye, .at = chosen.point});
}

// About the distance from a point to its neighbours, if they cover a surface evenly.
double spacing(std::span<const Vec> points) {
  Vec low = points.front(), high = low;
  for (const Vec& point : points) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], point[axis]);
      high[axis] = std::max(high[axis], point[axis]);
    }
  }
  return length(sub(high, low)) / std::sqrt(static_cast<double>(points.size()));
}

std::vector<Vec> points_of(std::span<const Aim> aims) {
  std::vector<Vec> points;
  points.reserve(aims.size());
  for (const Aim& aim : aims) points.push_back(aim.point);
  return points;
}

Result<Extent> extent_of(const SceneInfo& scene) {
  if (scene.bounds) return Extent(*scene.bounds);
  return Error{Code::kFailedPrecondition, "the scene has no triangles", "NO_TRIANGLES"};
}

// Where a ray goes to.
Vec goal(const Ray& ray, const Found& hit, const Vec& center) {
  const double square = dot(ray.direction, ray.direction);
  double t = hit.t;
  if (!std::isfinite(t)) {
    t = square > 0 ? dot(sub(center, ray.origin), ray.direction) / square : 0;
    t = std::clamp(t, ray.tmin, std::max(ray.tmin, ray.tmax));
  }
  return add(ray.origin, scale(ray.direction, t));
}

}  // namespace

const std::map<std::string, RayKind> kRayKinds{{"overview", RayKind::kOverview},
                                               {"closeup", RayKind::kCloseup},
                                               {"diffuse", RayKind::kDiffuse},
                                               {"shadow", RayKind::kShadow},
                                               {"random", RayKind::kRandom}};

Result<RayMaker> RayMaker::make(RayKind kind, const SceneInfo& scene, const Caster& cast,
                                std::uint64_t seed) {
  const auto extent = extent_of(scene);
  if (!extent) return extent.error();
  Engine random(seed);
  auto aims = find_aims(kind, scene, *extent, cast, random);
  if (!aims) return aims.error();
  RayMaker maker;
  maker.kind_ = kind;
  maker.seed_ = seed;
  if (!extent->fits_floats()) maker.precision_ = RaySet::Precision::kDouble;
  maker.diagonal_ = extent->diagonal;
  const std::size_t up = scene.up_axis == UpAxis::kZ ? 2 : 1;
  maker.light_ = extent->center;
  maker.light_[up] = extent->high[up] + extent->diagonal;
  maker.aims_ = *std::move(aims);
  return maker;
}

RaySet RayMaker::rays(double coverage, std::size_t count) const {
  Engine random(seed_);
  const std::vector<Vec> points = points_of(aims_);
  const auto chosen = nearest(points, points[random() % points.size()], coverage);
  std::vector<Vec> part;
  part.reserve(chosen.size());
  for (const std::size_t i : chosen) part.push_back(points[i]);
  const double spread = spacing(part);
  std::vector<Ray> rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Aim& aim = aims_[chosen[i % chosen.size()]];
    Ray& ray = rays[i];
    if (kind_ == RayKind::kDiffuse) {
      ray = {
          .origin = aim.point, .direction = bounce(aim.normal, random), .tmin = 1e-6 * diagonal_};
    } else if (kind_ == RayKind::kShadow) {
      const Vec light = add(light_, scale(in_ball(random), 0.02 * diagonal_));
      ray = {
          .origin = aim.point, .direction = sub(light, aim.point), .tmin = 1e-4, .tmax = 1 - 1e-4};
    } else {
      const Vec goal = add(aim.point, scale(in_ball(random), spread));
      ray = {.origin = aim.eye, .direction = unit(sub(goal, aim.eye))};
    }
  }
  return RaySet::of(rays, precision_);
}

Result<RaySet> part_of(const RaySet& rays, double coverage, const SceneInfo& scene,
                       const Caster& cast, std::uint64_t seed) {
  const auto extent = extent_of(scene);
  if (!extent) return extent.error();
  std::vector<Ray> all(rays.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = rays.at(i);
  const auto found = cast(all);
  if (!found) return found.error();
  std::vector<Vec> goals;
  std::vector<std::size_t> hits;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (std::isfinite((*found)[i].t)) hits.push_back(i);
    goals.push_back(goal(all[i], (*found)[i], extent->center));
  }
  if (hits.empty())
    return Error{Code::kFailedPrecondition, "none of the rays hits the scene", "TOO_FEW_HITS"};
  Engine random(seed);
  return rays.pick(nearest(goals, goals[hits[random() % hits.size()]], coverage));
}

}  // namespace sightline::client::load

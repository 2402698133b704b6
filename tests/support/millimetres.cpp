// The plate, the rays, and the comparison.
#include "tests/support/millimetres.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/support/random.h"

namespace sightline::tests {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;
using accel::geometry::Vec3d;
using accel::geometry::Vec3f;

namespace {

constexpr std::uint32_t kRidges = 1000;
constexpr std::uint32_t kPieces = 20;
constexpr double kMillimetre = 1e-3;
constexpr double kKilometre = 1e3;
constexpr double kRim = 0.05;
constexpr std::size_t kNudged = 5;

}  // namespace

TestMesh ridged_plate() {
  TestMesh mesh;
  constexpr std::uint32_t kColumns = 2 * kRidges;  // Up and down
  for (std::uint32_t row = 0; row <= kPieces; ++row) {
    for (std::uint32_t column = 0; column <= kColumns; ++column) {
      mesh.vertices.push_back(Vec3f(Vec3d{static_cast<double>(column) / kColumns - 0.5,
                                          static_cast<double>(row) / kPieces - 0.5,
                                          column % 2 == 0 ? 0 : kMillimetre}));
    }
  }
  for (std::uint32_t row = 0; row < kPieces; ++row) {
    for (std::uint32_t column = 0; column < kColumns; ++column) {
      const std::uint32_t a = row * (kColumns + 1) + column, b = a + kColumns + 1;
      mesh.faces.push_back({a, a + 1, b + 1});
      mesh.faces.push_back({a, b + 1, b});
    }
  }
  return mesh;
}

std::vector<Ray> kilometre_rays(std::size_t count, std::uint64_t seed, int bits) {
  Random random(seed);
  std::vector<Ray> rays;
  while (rays.size() < count) {
    Vec3d from = random.direction();
    if (std::fabs(from.z) < 0.5) continue;
    from.z = std::fabs(from.z);
    const Vec3d at{random.uniform(kRim - 0.5, 0.5 - kRim), random.uniform(kRim - 0.5, 0.5 - kRim),
                   kMillimetre / 2};
    Ray ray;
    for (std::size_t k = 0; k < 3; ++k)
      ray.origin[k] = std::ldexp(std::round(std::ldexp(from[k] * kKilometre, bits)), -bits);
    const Vec3d way = at - ray.origin;
    ray.direction = way * (1 / length(way));
    rays.push_back(ray);
  }
  return rays;
}

std::vector<Ray> with_nudges(std::span<const Ray> rays, double distance) {
  std::vector<Ray> nudged;
  nudged.reserve(kNudged * rays.size());
  for (const Ray& ray : rays) {
    for (const Vec3d& by : {Vec3d{0, 0, 0}, Vec3d{distance, 0, 0}, Vec3d{-distance, 0, 0},
                            Vec3d{0, distance, 0}, Vec3d{0, -distance, 0}}) {
      nudged.push_back(ray);
      nudged.back().origin = ray.origin + by;
    }
  }
  return nudged;
}

Displacement displacement(std::span<const Hit> at_origin, std::span<const Hit> elsewhere) {
  Displacement d;
  for (std::size_t i = 0; i < at_origin.size(); i += kNudged) {
    const std::span<const Hit> nudges = at_origin.subspan(i, kNudged);
    const Hit &here = nudges[0], &there = elsewhere[i];
    ++d.rays;
    if (here.state != HitState::kHit || there.state != HitState::kHit) {
      ++d.missed;
      continue;
    }
    const bool steady = std::all_of(nudges.begin(), nudges.end(), [&](const Hit& hit) {
      return hit.state == HitState::kHit && hit.primitive == here.primitive;
    });
    if (!steady) continue;
    ++d.steady;
    if (there.primitive != here.primitive) ++d.others;
    d.largest_t_error = std::max(d.largest_t_error, std::fabs(there.t - here.t));
  }
  return d;
}

std::string Displacement::report() const {
  return fmt::format(
      "{} rays, {} steady, {} missed, {} on another primitive, largest error of t {} m", rays,
      steady, missed, others, largest_t_error);
}

}  // namespace sightline::tests

// Balls on closed paths through a cube.
#include "tests/bench/scenes/generate_swarm.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::bench {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using scenegraph::model::Affine;
using tests::Random;

namespace {

constexpr std::uint64_t kSeed = 2006;
constexpr double kHalfSide = 50;  // Of the cube
constexpr double kLeast = 0.8, kMost = 2.5;
constexpr std::size_t kWaypoints = 4;

// A closed spline of parabolas through the midpoints of the waypoints' polygon.
Vec3d on_path(const std::array<Vec3d, kWaypoints>& waypoints, double turn) {
  const double at = turn * kWaypoints;
  const auto leg = static_cast<std::size_t>(at) % kWaypoints;
  const double s = at - std::floor(at);
  const Vec3d &a = waypoints[leg], &b = waypoints[(leg + 1) % kWaypoints],
              &c = waypoints[(leg + 2) % kWaypoints];
  return (a + b) * (0.5 * (1 - s) * (1 - s)) + b * (2 * s * (1 - s)) + (b + c) * (0.5 * s * s);
}

// Rotation about a unit axis, by Rodrigues' formula.
Affine turned(const Vec3d& k, double cosine, double sine, const Vec3d& at) {
  const double w = 1 - cosine;
  return {{cosine + k.x * k.x * w, k.x * k.y * w - k.z * sine, k.x * k.z * w + k.y * sine, at.x,
           k.y * k.x * w + k.z * sine, cosine + k.y * k.y * w, k.y * k.z * w - k.x * sine, at.y,
           k.z * k.x * w - k.y * sine, k.z * k.y * w + k.x * sine, cosine + k.z * k.z * w, at.z}};
}

}  // namespace

std::vector<Affine> swarm_transforms(std::size_t parts, std::size_t frame) {
  static const auto kCircle = tests::unit_circle(kSwarmFrames);
  frame %= kSwarmFrames;
  std::vector<Affine> transforms;
  transforms.reserve(parts);
  for (std::size_t part = 0; part < parts; ++part) {
    Random random(kSeed, part);
    std::array<Vec3d, kWaypoints> waypoints;
    for (Vec3d& w : waypoints) {
      w = {random.uniform(-kHalfSide, kHalfSide), random.uniform(-kHalfSide, kHalfSide),
           random.uniform(-kHalfSide, kHalfSide)};
    }
    const Vec3d at =
        on_path(waypoints, static_cast<double>(frame) / static_cast<double>(kSwarmFrames));
    transforms.push_back(
        turned(random.direction(), kCircle[frame].first, kCircle[frame].second, at));
  }
  return transforms;
}

SceneSource make_swarm(std::uint64_t triangles) {
  const std::uint64_t parts = (triangles + kTrianglesPerPart - 1) / kTrianglesPerPart;
  const std::vector<Affine> transforms = swarm_transforms(parts, 0);
  const tests::TestMesh ball = tests::icosphere(1);
  SceneSource scene;
  for (std::size_t part = 0; part < parts; ++part) {
    Random random(kSeed + 1, part);
    const auto radius = static_cast<float>(random.uniform(kLeast, kMost));
    SourceMesh mesh{ball.vertices, ball.faces};
    for (Vec3f& v : mesh.vertices) v = v * radius;
    mesh.faces.resize(std::min(kTrianglesPerPart, triangles - part * kTrianglesPerPart));
    scene.add_node(std::nullopt, fmt::format("part {}", part), transforms[part],
                   scene.add_mesh(std::move(mesh)));
  }
  return scene;
}

}  // namespace sightline::bench

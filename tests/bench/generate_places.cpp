// City, stadium, herd, box: scenes of many parts.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/bench/generators.h"
#include "tests/bench/scene_geometry.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::bench {

using accel::Vec3d;
using accel::Vec3f;
using scenegraph::Affine;
using tests::Random;

namespace {

constexpr std::uint64_t kBoxesPerObject = 50;
constexpr std::uint64_t kObjectsPerDistrict = 16;

SourceMesh to_source(tests::TestMesh mesh) {
  return {std::move(mesh.vertices), std::move(mesh.faces)};
}

// Fifty houses on a raster of 8 x 7 lots of 10 units.
SourceMesh make_block(std::uint64_t boxes, Random& random) {
  tests::TestMesh block;
  for (std::uint64_t i = 0; i < boxes; ++i) {
    const double x = static_cast<double>(i % 8) * 10, z = static_cast<double>(i / 8) * 10;
    const double wide = random.uniform(4, 9), deep = random.uniform(4, 9);
    // Few towers over many low houses.
    const double luck = random.uniform();
    const double high = 4 + 60 * luck * luck * luck * luck;
    block.append(tests::box(Vec3f(Vec3d{x, 0, z}), Vec3f(Vec3d{x + wide, high, z + deep})));
  }
  return to_source(std::move(block));
}

// Steps that rise outward around the pitch, each a tread and a riser.
SourceMesh make_stand(std::uint32_t tiers, std::uint32_t segments) {
  const auto circle = tests::unit_circle(segments);
  SourceMesh mesh;
  const auto add_circle = [&](double radius, double height) {
    for (const auto& [x, z] : circle) {
      mesh.vertices.push_back(Vec3f(Vec3d{1.3 * radius * x, height, radius * z}));
    }
  };
  for (std::uint32_t tier = 0; tier < tiers; ++tier) {
    add_circle(60 + tier, 2 + 0.6 * tier);
    add_circle(61 + tier, 2 + 0.6 * tier);
  }
  for (std::uint32_t ring = 0; ring + 1 < 2 * tiers; ++ring) {
    for (std::uint32_t i = 0; i < segments; ++i) {
      const std::uint32_t a = ring * segments + i, b = ring * segments + (i + 1) % segments;
      mesh.faces.push_back({a, b, a + segments});
      mesh.faces.push_back({b, b + segments, a + segments});
    }
  }
  return mesh;
}

}  // namespace

SceneSource make_city(std::uint64_t boxes, std::uint64_t seed) {
  Random random(seed);
  SceneSource scene;
  const std::size_t city = scene.add_node(std::nullopt, "city");
  const std::uint64_t objects = (boxes + kBoxesPerObject - 1) / kBoxesPerObject;
  const std::uint64_t districts = (objects + kObjectsPerDistrict - 1) / kObjectsPerDistrict;
  const auto side =
      static_cast<std::uint64_t>(std::ceil(std::sqrt(static_cast<double>(districts))));
  for (std::uint64_t d = 0, object = 0; d < districts; ++d) {
    const double x = static_cast<double>(d % side) * 420, z = static_cast<double>(d / side) * 400;
    const std::size_t district =
        scene.add_node(city, fmt::format("district {}", d), translation(x, 0, z));
    for (std::uint64_t k = 0; k < kObjectsPerDistrict && object < objects; ++k, ++object) {
      const std::uint64_t left = boxes - object * kBoxesPerObject;
      const std::size_t mesh = scene.add_mesh(make_block(std::min(left, kBoxesPerObject), random));
      scene.add_node(
          district, fmt::format("object {}", object),
          translation(static_cast<double>(k % 4) * 95, 0, static_cast<double>(k / 4) * 85), mesh);
    }
  }
  return scene;
}

SceneSource make_stadium() {
  SceneSource scene;
  const std::size_t stadium = scene.add_node(std::nullopt, "stadium");
  scene.add_node(stadium, "stand", {}, scene.add_mesh(make_stand(40, 256)));
  scene.add_node(stadium, "pitch", {},
                 scene.add_mesh(to_source(tests::box({-52.5f, -1, -34}, {52.5f, 0, 34}))));
  constexpr double kRadius = 0.15;
  const Affine place{{kRadius, 0, 0, 0, 0, kRadius, 0, kRadius, 0, 0, kRadius, 0}};
  scene.add_node(stadium, "ball", place, scene.add_mesh(to_source(tests::icosphere(6))));
  return scene;
}

SceneSource make_herd(const SceneSource& animal, std::uint64_t copies, std::uint64_t seed) {
  const SceneGeometry geometry(animal);
  const double spacing = 1.2 * length(geometry.hi() - geometry.lo());
  const Vec3d center = geometry.center();
  const auto side = static_cast<std::uint64_t>(std::ceil(std::sqrt(static_cast<double>(copies))));
  Random random(seed);
  SceneSource scene;
  for (std::uint64_t copy = 0; copy < copies; ++copy) {
    const std::size_t first_mesh = scene.meshes.size();
    scene.meshes.insert(scene.meshes.end(), animal.meshes.begin(), animal.meshes.end());
    const Vec3d heading = random.direction();
    const double flat = std::sqrt(heading.x * heading.x + heading.z * heading.z);
    const double c = flat > 0 ? heading.x / flat : 1, s = flat > 0 ? heading.z / flat : 0;
    const Affine turn{{c, 0, s, 0, 0, 1, 0, 0, -s, 0, c, 0}};
    const Affine place = compose(translation(static_cast<double>(copy % side) * spacing, 0,
                                             static_cast<double>(copy / side) * spacing),
                                 compose(turn, translation(-center.x, -center.y, -center.z)));
    const std::size_t root = scene.add_node(std::nullopt, fmt::format("copy {}", copy), place);
    const std::size_t first_node = scene.nodes.size();
    for (const SourceNode& node : animal.nodes) {
      SourceNode twin = node;
      twin.parent = node.parent ? first_node + *node.parent : root;
      if (node.mesh) twin.mesh = first_mesh + *node.mesh;
      scene.nodes.push_back(std::move(twin));
    }
  }
  return scene;
}

SceneSource make_boxed(SceneSource scene) {
  const SceneGeometry geometry(scene);
  const Vec3d center = geometry.center();
  const Vec3d half = (geometry.hi() - geometry.lo()) * 0.75;
  // A flat scene still gets a box with an inside.
  const double least = 0.05 * geometry.diagonal();
  const Affine place{{std::max(half.x, least), 0, 0, center.x, 0, std::max(half.y, least), 0,
                      center.y, 0, 0, std::max(half.z, least), center.z}};
  scene.add_node(std::nullopt, "box", place, scene.add_mesh(to_source(tests::cube())));
  return scene;
}

}  // namespace sightline::bench

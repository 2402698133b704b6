// City, village, stadium, herd, box: scenes of many parts.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "tests/bench/scenes/generators.h"
#include "tests/bench/scenes/scene_geometry.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::bench {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using scenegraph::model::Affine;
using tests::Random;

namespace {

constexpr std::uint64_t kBoxesPerObject = 50;

SourceMesh to_source(tests::TestMesh mesh) {
  return {std::move(mesh.vertices), std::move(mesh.faces)};
}

// Fifty houses on a raster of 8 x 7 lots of 10 units.
SourceMesh make_block(std::uint64_t boxes, Random& random) {
  tests::TestMesh block;
  for (std::uint64_t i = 0; i < boxes; ++i) {
    const double x = static_cast<double>(i % 8) * 10, z = static_cast<double>(i / 8) * 10;
    const double wide = random.uniform(4, 9), deep = random.uniform(4, 9);
    // Few towers and many low houses.
    const double luck = random.uniform();
    const double high = 4 + 60 * luck * luck * luck * luck;
    block.append(tests::box(Vec3f(Vec3d{x, 0, z}), Vec3f(Vec3d{x + wide, high, z + deep})));
  }
  return to_source(std::move(block));
}

// Walls, a ceiling and a floor, and a roof of four sides on top.
SourceMesh make_house(Random& random) {
  const double wide = random.uniform(6, 12), deep = random.uniform(6, 12);
  const double high = random.uniform(3, 8);
  SourceMesh house = to_source(tests::box({0, 0, 0}, Vec3f(Vec3d{wide, high, deep})));
  const auto first = static_cast<std::uint32_t>(house.vertices.size());
  for (const Vec3d& p : {Vec3d{0, high, 0}, Vec3d{0, high, deep}, Vec3d{wide, high, deep},
                         Vec3d{wide, high, 0}, Vec3d{wide / 2, high + wide / 4, deep / 2}}) {
    house.vertices.push_back(Vec3f(p));
  }
  for (std::uint32_t side = 0; side < 4; ++side) {
    house.faces.push_back({first + side, first + (side + 1) % 4, first + 4});
  }
  return house;
}

struct Spacing {
  double x, z;
};

constexpr std::uint64_t kPerGroup = 16;  // four by four
constexpr std::array<std::string_view, 7> kGroupNames{"district", "borough",   "county", "province",
                                                      "country",  "continent", "planet"};

// Nested groups of sixteen, down to `objects` objects. The base-sixteen digits of k decide where
// object k stands, whatever `objects` is: a smaller world is a corner of a larger one.
class Nest {
 public:
  Nest(SceneSource& scene, std::uint64_t objects, Spacing between, Spacing street)
      : scene_(scene), objects_(objects), between_(between), street_(street) {}

  template <class AddObject>
  void fill(std::size_t parent, std::size_t level, std::uint64_t first,
            const AddObject& add_object) {
    std::uint64_t size = 1;  // Objects of a child
    Spacing spacing = between_;
    for (std::size_t l = 0; l < level; ++l) {
      size *= kPerGroup;
      spacing = {4 * spacing.x + street_.x, 4 * spacing.z + street_.z};
    }
    for (std::uint64_t k = 0; k < kPerGroup && first + k * size < objects_; ++k) {
      const Affine transform = translation(static_cast<double>(k % 4) * spacing.x, 0,
                                           static_cast<double>(k / 4) * spacing.z);
      if (level == 0) {
        add_object(parent, first + k, transform);
        continue;
      }
      const std::string name =
          fmt::format("{} {}", kGroupNames[level - 1], (first + k * size) / size);
      fill(scene_.add_node(parent, name, transform), level - 1, first + k * size, add_object);
    }
  }

 private:
  SceneSource& scene_;
  std::uint64_t objects_;
  Spacing between_, street_;
};

// A root over the fewest levels of groups that suffice, but at least one. `between` separates
// neighbors of a group, and a street surrounds each group.
template <class AddObject>
void nest(SceneSource& scene, std::string name, std::uint64_t objects, Spacing between,
          Spacing street, const AddObject& add_object) {
  std::size_t level = 1;
  for (std::uint64_t capacity = kPerGroup * kPerGroup; capacity < objects; capacity *= kPerGroup)
    ++level;
  const std::size_t root = scene.add_node(std::nullopt, std::move(name));
  Nest(scene, objects, between, street).fill(root, level, 0, add_object);
}

// Steps that rise outward around the pitch, each a tread and a riser.
SourceMesh make_stand(std::uint32_t rows, std::uint32_t segments) {
  const auto circle = tests::unit_circle(segments);
  SourceMesh mesh;
  const auto add_circle = [&](double radius, double height) {
    for (const auto& [x, z] : circle) {
      mesh.vertices.push_back(Vec3f(Vec3d{1.3 * radius * x, height, radius * z}));
    }
  };
  for (std::uint32_t row = 0; row < rows; ++row) {
    add_circle(60 + row, 2 + 0.6 * row);
    add_circle(61 + row, 2 + 0.6 * row);
  }
  for (std::uint32_t ring = 0; ring + 1 < 2 * rows; ++ring) {
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
  const std::uint64_t objects = (boxes + kBoxesPerObject - 1) / kBoxesPerObject;
  const auto add_object = [&](std::size_t district, std::uint64_t object, const Affine& transform) {
    const std::uint64_t left = boxes - object * kBoxesPerObject;
    const std::size_t mesh = scene.add_mesh(make_block(std::min(left, kBoxesPerObject), random));
    scene.add_node(district, fmt::format("object {}", object), transform, mesh);
  };
  nest(scene, "city", objects, {95, 85}, {40, 60}, add_object);
  return scene;
}

SceneSource make_village(std::uint64_t houses, std::uint64_t seed) {
  Random random(seed);
  SceneSource scene;
  const auto add_house = [&](std::size_t block, std::uint64_t house, const Affine& transform) {
    const std::size_t mesh = scene.add_mesh(make_house(random));
    scene.add_node(block, fmt::format("house {}", house), transform, mesh);
  };
  nest(scene, "village", houses, {14, 14}, {8, 8}, add_house);
  return scene;
}

SceneSource make_stadium() {
  SceneSource scene;
  const std::size_t stadium = scene.add_node(std::nullopt, "stadium");
  scene.add_node(stadium, "stand", {}, scene.add_mesh(make_stand(40, 256)));
  scene.add_node(stadium, "pitch", {},
                 scene.add_mesh(to_source(tests::box({-52.5f, -1, -34}, {52.5f, 0, 34}))));
  constexpr double kRadius = 0.15;
  const Affine transform{{kRadius, 0, 0, 0, 0, kRadius, 0, kRadius, 0, 0, kRadius, 0}};
  scene.add_node(stadium, "ball", transform, scene.add_mesh(to_source(tests::icosphere(6))));
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
    const Affine transform = compose(translation(static_cast<double>(copy % side) * spacing, 0,
                                                 static_cast<double>(copy / side) * spacing),
                                     compose(turn, translation(-center.x, -center.y, -center.z)));
    const std::size_t root = scene.add_node(std::nullopt, fmt::format("copy {}", copy), transform);
    const std::size_t first_node = scene.nodes.size();
    for (const SourceNode& node : animal.nodes) {
      SourceNode copied = node;
      copied.parent = node.parent ? first_node + *node.parent : root;
      if (node.mesh) copied.mesh = first_mesh + *node.mesh;
      scene.nodes.push_back(std::move(copied));
    }
  }
  return scene;
}

SceneSource make_shuffled(SceneSource scene, std::uint64_t seed) {
  Random random(seed);
  for (SourceMesh& mesh : scene.meshes) {
    for (std::size_t i = mesh.faces.size(); i > 1; --i) {
      std::swap(mesh.faces[i - 1], mesh.faces[random.below(i)]);
    }
  }
  return scene;
}

SceneSource make_spheres(std::uint64_t copies, int level, double offset, std::uint64_t seed) {
  SceneSource scene;
  const std::size_t sphere = scene.add_mesh(to_source(tests::icosphere(level)));
  const auto side = static_cast<std::uint64_t>(std::ceil(std::cbrt(static_cast<double>(copies))));
  for (std::uint64_t i = 0; i < copies; ++i) {
    Random random(seed, i);
    const auto angle = [&] { return random.uniform(0, 360); };
    const auto scale = [&] { return std::exp2(random.uniform(-3, 3)); };
    const auto share = [&] { return random.uniform(-1, 1); };
    const double mirror = i % 2 == 0 ? 1 : -1;
    const Affine shear{{mirror, share(), share(), 0, 0, 1, share(), 0, 0, 0, 1, 0}},
        scales{{scale(), 0, 0, 0, 0, scale(), 0, 0, 0, 0, scale(), 0}};
    const auto at = [&](std::uint64_t lot) { return offset + 6 * static_cast<double>(lot); };
    const Affine moved = translation(at(i % side), at(i / side % side), at(i / side / side));
    const Affine turned = compose(moved, rotation(angle(), angle(), angle()));
    scene.add_node(std::nullopt, fmt::format("sphere {}", i),
                   compose(turned, compose(shear, scales)), sphere);
  }
  return scene;
}

SceneSource make_boxed(SceneSource scene) {
  const SceneGeometry geometry(scene);
  const Vec3d center = geometry.center();
  const Vec3d half = (geometry.hi() - geometry.lo()) * 0.75;
  // A flat scene gets a box with positive extent.
  const double least = 0.05 * geometry.diagonal();
  const Affine transform{{std::max(half.x, least), 0, 0, center.x, 0, std::max(half.y, least), 0,
                          center.y, 0, 0, std::max(half.z, least), center.z}};
  scene.add_node(std::nullopt, "box", transform, scene.add_mesh(to_source(tests::cube())));
  return scene;
}

}  // namespace sightline::bench

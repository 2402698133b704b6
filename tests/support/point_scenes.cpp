// Scenes for points, and fresh trees over them.
#include "tests/support/point_scenes.h"

#include <array>
#include <cassert>
#include <cmath>
#include <string>
#include <utility>

#include "scenegraph/model/eviction.h"
#include "scenegraph/query/build.h"
#include "scenegraph/scene.h"

namespace sightline::tests {
namespace {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using scenegraph::model::Affine;

}  // namespace

FreshScene::FreshScene(const std::vector<ScenePart>& parts)
    : memory_(std::make_shared<accel::kdtree::TreeMemory>(std::uint64_t{1} << 40)) {
  std::vector<scenegraph::model::Update> updates;
  for (const ScenePart& part : parts) {
    meshes_.push_back(
        *scenegraph::model::Mesh::make(part.mesh.vertices, part.mesh.faces, {.memory = memory_}));
    for (const Affine& frame : part.frames) {
      scenegraph::model::PutNode put;
      put.node = -1 - static_cast<scenegraph::model::NodeRef>(updates.size());
      put.parent_from_local = frame;
      put.mesh = meshes_.back();
      put.mesh_digest = std::to_string(meshes_.size());
      updates.emplace_back(std::move(put));
      faces_ += part.mesh.faces.size();
    }
  }
  scenegraph::Scene scene;
  if (scene.apply(updates)) snapshot_ = scene.snapshot();
}

void FreshScene::build_meshes() const {
  scenegraph::query::BuildProgress progress;
  const auto nodes = scenegraph::query::mesh_nodes_under(*snapshot_, {}, {});
  const bool is_built = nodes && scenegraph::query::build_mesh_trees(*nodes, progress, nullptr) &&
                        scenegraph::query::build_scene_tree(*snapshot_, progress, nullptr);
  assert(is_built);
  (void)is_built;
}

void FreshScene::cool() const { scenegraph::model::evict(meshes_, *memory_, memory_->held() / 2); }

Affine turned(Random& random, const Vec3d& lengths, const Vec3d& offset) {
  const Vec3d x = random.direction(), across = cross(x, random.direction()),
              y = across * (1 / length(across)), z = cross(x, y);
  Affine frame;
  for (std::size_t i = 0; i < 3; ++i) {
    frame.m[4 * i] = x[i] * lengths.x;
    frame.m[4 * i + 1] = y[i] * lengths.y;
    frame.m[4 * i + 2] = z[i] * lengths.z;
    frame.m[4 * i + 3] = offset[i];
  }
  return frame;
}

Affine placed_at(const Vec3d& offset, double scale) {
  return {{scale, 0, 0, offset.x, 0, scale, 0, offset.y, 0, 0, scale, offset.z}};
}

TestMesh on_grid(TestMesh mesh, float step) {
  for (Vec3f& v : mesh.vertices) {
    for (std::size_t axis = 0; axis < 3; ++axis) v[axis] = std::round(v[axis] / step) * step;
  }
  return mesh;
}

TestMesh scaled(TestMesh mesh, float scale, const Vec3f& offset) {
  for (Vec3f& v : mesh.vertices) v = v * scale + offset;
  return mesh;
}

TestMesh tube(std::uint32_t corners, std::uint32_t rings) {
  TestMesh mesh;
  const auto circle = unit_circle(corners);
  for (std::uint32_t ring = 0; ring <= rings; ++ring) {
    for (const auto& [x, y] : circle) mesh.vertices.push_back(Vec3f(Vec3d{x, y, 1.0 * ring}));
  }
  for (std::uint32_t ring = 0; ring < rings; ++ring) {
    for (std::uint32_t i = 0; i < corners; ++i) {
      const std::uint32_t a = ring * corners + i, b = ring * corners + (i + 1) % corners;
      mesh.faces.push_back({a, b, b + corners});
      mesh.faces.push_back({a, b + corners, a + corners});
    }
  }
  return mesh;
}

TestMesh long_needles(std::uint32_t triangles, std::uint64_t seed) {
  Random random(seed);
  TestMesh mesh;
  for (std::uint32_t i = 0; i < triangles; ++i) {
    const Vec3d from = random.direction() * random.uniform(), along = random.direction() * 10.0;
    mesh.vertices.push_back(Vec3f(from));
    mesh.vertices.push_back(Vec3f(from + along));
    mesh.vertices.push_back(
        Vec3f(from + along * random.uniform(-0.5, 1.5) + random.direction() * 1e-7));
    mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

TestMesh points_and_segments(std::uint32_t faces, std::uint64_t seed) {
  Random random(seed);
  TestMesh mesh;
  for (std::uint32_t i = 0; i < faces; ++i) {
    const Vec3d at{random.uniform(), random.uniform(), random.uniform()};
    // Sums of multiples of 2^-10 are exact.
    const std::vector<Vec3f> exact =
        on_grid({{Vec3f(at), Vec3f(random.direction() * 0.1)}, {}}, 0x1p-10f).vertices;
    const std::uint32_t a = 3 * i, b = a + 1, c = a + 2;
    for (int k = 0; k < 3; ++k)
      mesh.vertices.push_back(exact[0] + exact[1] * static_cast<float>(k));
    const std::array<accel::geometry::Face, 5> kinds{
        {{a, a, a}, {a, b, b}, {b, a, b}, {a, b, c}, {b, c, a}}};
    mesh.faces.push_back(kinds[i % kinds.size()]);
  }
  return mesh;
}

TestMesh tripled(const TestMesh& mesh) {
  TestMesh all{mesh.vertices, {}};
  for (const accel::geometry::Face& f : mesh.faces)
    all.faces.insert(all.faces.end(), {f, {f[1], f[2], f[0]}, {f[1], f[0], f[2]}});
  return all;
}

TestMesh whole_planes() {
  TestMesh mesh;
  const auto add = [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Vec3d& v : {a, b, c}) mesh.vertices.push_back(Vec3f(v));
    mesh.faces.push_back({first, first + 1, first + 2});
  };
  for (const Vec3d& n : {Vec3d{1, 2, 2}, Vec3d{2, 3, 6}, Vec3d{3, 4, 0}, Vec3d{0, 0, 1}}) {
    const Vec3d along = n.x == 0 ? Vec3d{1, 0, 0} : Vec3d{n.y, -n.x, 0}, across = cross(n, along);
    for (int i = -2; i < 3; ++i) {
      const Vec3d at = along * (4.0 * i);
      add(at - along * 2.0 - across * 2.0, at + along * 3.0 - across, at + along + across * 4.0);
      add(at, at + across, at + along);
    }
  }
  for (const double half : {0.5, 1.5, 2.5}) {
    add({-half, -1, -1}, {-half, 2, -1}, {-half, -1, 2});
    add({-half, 0, 0}, {-half, 2, 0}, {-half, 2, 0});
  }
  return mesh;
}

}  // namespace sightline::tests

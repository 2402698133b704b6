// A scene as plain arrays, and the snapshot made from it.
#include "tests/bench/scenes/scene_source.h"
#include "accel/published/any_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "scenegraph/scene.h"

namespace sightline::bench {

using scenegraph::model::Affine;

namespace {

// Sine and cosine of whole quarter turns without the library's last-bit errors.
std::pair<double, double> sine_cosine(double degrees) {
  const double quarters = degrees / 90;
  if (quarters == std::floor(quarters)) {
    const auto k = static_cast<std::size_t>(std::fmod(std::fmod(quarters, 4) + 4, 4));
    constexpr double kSine[] = {0, 1, 0, -1};
    return {kSine[k], kSine[(k + 1) % 4]};
  }
  const double radians = degrees * (std::numbers::pi / 180);
  return {std::sin(radians), std::cos(radians)};
}

accel::geometry::Vec3f to_float(const accel::geometry::Vec3d& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// turn * a * turn^-1.
Affine as_seen_turned(const Affine& a, const Affine& turn) {
  const auto& t = turn.m;
  const Affine back{{t[0], t[4], t[8], 0, t[1], t[5], t[9], 0, t[2], t[6], t[10], 0}};
  Affine turned = compose(turn, compose(a, back));
  // All directions have equal factors: rotating changes nothing and would only round.
  const std::array<std::size_t, 6> off{1, 2, 4, 6, 8, 9};
  const bool even = a.m[0] == a.m[5] && a.m[0] == a.m[10] &&
                    std::all_of(off.begin(), off.end(), [&](std::size_t i) { return a.m[i] == 0; });
  if (even) {
    for (std::size_t row = 0; row < 3; ++row)
      std::copy_n(a.m.begin() + static_cast<std::ptrdiff_t>(4 * row), 3,
                  turned.m.begin() + static_cast<std::ptrdiff_t>(4 * row));
  }
  return turned;
}

}  // namespace

std::uint64_t SceneSource::unique_triangles() const {
  std::uint64_t triangles = 0;
  for (const SourceMesh& mesh : meshes) {
    for (const accel::geometry::Face& face : mesh.faces)
      triangles += face[0] != accel::geometry::kNoVertex;
  }
  return triangles;
}

std::size_t SceneSource::add_mesh(SourceMesh mesh) {
  meshes.push_back(std::move(mesh));
  return meshes.size() - 1;
}

std::size_t SceneSource::add_node(std::optional<std::size_t> parent, std::string name,
                                  const Affine& parent_from_local,
                                  std::optional<std::size_t> mesh) {
  nodes.push_back({parent, std::move(name), parent_from_local, mesh});
  return nodes.size() - 1;
}

Affine translation(double x, double y, double z) { return {{1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}}; }

Affine rotation(double x, double y, double z) {
  const auto [sx, cx] = sine_cosine(x);
  const auto [sy, cy] = sine_cosine(y);
  const auto [sz, cz] = sine_cosine(z);
  const Affine about_x{{1, 0, 0, 0, 0, cx, -sx, 0, 0, sx, cx, 0}};
  const Affine about_y{{cy, 0, sy, 0, 0, 1, 0, 0, -sy, 0, cy, 0}};
  const Affine about_z{{cz, -sz, 0, 0, sz, cz, 0, 0, 0, 0, 1, 0}};
  return compose(about_z, compose(about_y, about_x));
}

void move_scene(SceneSource& scene, const Affine& world_from_world) {
  for (SourceNode& node : scene.nodes) {
    if (!node.parent) node.parent_from_local = compose(world_from_world, node.parent_from_local);
  }
}

void rotate(SceneSource& scene, const Affine& turn) {
  for (SourceMesh& mesh : scene.meshes) {
    for (accel::geometry::Vec3f& v : mesh.vertices)
      v = to_float(turn.point(accel::geometry::Vec3d(v)));
  }
  for (SourceNode& node : scene.nodes)
    node.parent_from_local = as_seen_turned(node.parent_from_local, turn);
}

SceneSource merged(const SceneSource& scene) {
  SourceMesh all;
  std::vector<Affine> world_from_node;
  for (const SourceNode& node : scene.nodes) {
    world_from_node.push_back(node.parent
                                  ? compose(world_from_node[*node.parent], node.parent_from_local)
                                  : node.parent_from_local);
    if (!node.mesh) continue;
    const SourceMesh& mesh = scene.meshes[*node.mesh];
    const auto first = static_cast<std::uint32_t>(all.vertices.size());
    for (const accel::geometry::Vec3f& v : mesh.vertices)
      all.vertices.push_back(to_float(world_from_node.back().point(accel::geometry::Vec3d(v))));
    for (accel::geometry::Face face : mesh.faces) {
      for (std::uint32_t& index : face) {
        if (index != accel::geometry::kNoVertex) index += first;
      }
      all.faces.push_back(face);
    }
  }
  SceneSource one;
  one.add_node(std::nullopt, "merged", {}, one.add_mesh(std::move(all)));
  return one;
}

Status fill(scenegraph::Scene& empty, SceneSource scene,
            const accel::published::AnyBuilder& builder, accel::mesh::References references,
            std::shared_ptr<accel::kdtree::TreeMemory> memory) {
  accel::mesh::TreeBuilder of_trees = builder;
  of_trees.memory = std::move(memory);
  std::vector<std::shared_ptr<const scenegraph::model::Mesh>> meshes;
  meshes.reserve(scene.meshes.size());
  for (SourceMesh& mesh : scene.meshes) {
    auto made = scenegraph::model::Mesh::make(std::move(mesh.vertices), std::move(mesh.faces),
                                              of_trees, references);
    if (!made.ok()) return made.error();
    meshes.push_back(*std::move(made));
  }
  const auto alias = [](std::size_t node) {
    return -static_cast<scenegraph::model::NodeRef>(node) - 1;
  };
  std::vector<scenegraph::model::Update> updates;
  updates.reserve(scene.nodes.size());
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    SourceNode& node = scene.nodes[i];
    scenegraph::model::PutNode put;
    put.node = alias(i);
    put.parent = node.parent ? alias(*node.parent) : 0;
    put.name = std::move(node.name);
    put.parent_from_local = node.parent_from_local;
    put.mobility = node.mobility;
    if (node.mesh) {
      put.mesh = meshes[*node.mesh];
      put.mesh_digest = std::to_string(*node.mesh);
    }
    updates.emplace_back(std::move(put));
  }
  const auto applied = empty.apply(updates);
  return applied.ok() ? Status() : Status(applied.error());
}

Result<std::shared_ptr<const scenegraph::revision::Snapshot>> assemble(
    SceneSource scene, const accel::published::AnyBuilder& builder,
    accel::mesh::References references, std::shared_ptr<accel::kdtree::TreeMemory> memory) {
  scenegraph::Scene live;
  if (Status filled = fill(live, std::move(scene), builder, references, std::move(memory));
      !filled) {
    return filled.error();
  }
  return live.snapshot();
}

}  // namespace sightline::bench

// A scene as plain arrays, and how it becomes a snapshot.
#include "tests/bench/scene_source.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "scenegraph/scene.h"

namespace sightline::bench {

using scenegraph::Affine;

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

}  // namespace

std::uint64_t SceneSource::unique_triangles() const {
  std::uint64_t triangles = 0;
  for (const SourceMesh& mesh : meshes) {
    for (const accel::Face& face : mesh.faces) triangles += face[0] != accel::kNoVertex;
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

void rotate(SceneSource& scene, const Affine& turn) {
  for (SourceNode& node : scene.nodes) {
    if (!node.parent) node.parent_from_local = compose(turn, node.parent_from_local);
  }
}

Status fill(scenegraph::Scene& empty, SceneSource scene, const accel::AnyBuilder& builder,
            accel::References references) {
  std::vector<std::shared_ptr<const scenegraph::Mesh>> meshes;
  meshes.reserve(scene.meshes.size());
  for (SourceMesh& mesh : scene.meshes) {
    auto made = scenegraph::Mesh::make(std::move(mesh.vertices), std::move(mesh.faces), builder,
                                       references);
    if (!made.ok()) return made.error();
    meshes.push_back(std::move(made).value());
  }
  const auto alias = [](std::size_t node) { return -static_cast<scenegraph::NodeRef>(node) - 1; };
  std::vector<scenegraph::Update> updates;
  updates.reserve(scene.nodes.size());
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    SourceNode& node = scene.nodes[i];
    scenegraph::PutNode put;
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

Result<std::shared_ptr<const scenegraph::Snapshot>> assemble(SceneSource scene,
                                                             const accel::AnyBuilder& builder,
                                                             accel::References references) {
  scenegraph::Scene live;
  if (Status filled = fill(live, std::move(scene), builder, references); !filled) {
    return filled.error();
  }
  return live.snapshot();
}

}  // namespace sightline::bench

// Converts nodes first, then animations, then vertices and faces.
#include "client/importer/scene_from_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "client/importer/finite.h"
#include "client/importer/frame.h"
#include "client/importer/node_name.h"
#include "client/importer/rebase.h"
#include "client/importer/rest_pose.h"
#include "client/importer/self_check.h"
#include "client/importer/triangulate.h"

namespace sightline::client::importer {
namespace {

Status check_mesh(const FileMesh& mesh, std::size_t nodes) {
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const std::uint32_t vertex : mesh.faces[f]) {
      if (vertex < mesh.vertices.size()) continue;
      return import_error(fmt::format("mesh '{}': polygon {} names vertex {}, but there are {}",
                                      node_name(mesh.name), f, vertex, mesh.vertices.size()));
    }
  }
  for (std::size_t b = 0; b < mesh.skin.bones.size(); ++b) {
    const Skin::Bone& bone = mesh.skin.bones[b];
    if (bone.node < nodes && is_finite(bone.bone_from_mesh)) continue;
    return import_error(
        fmt::format("mesh '{}': the transform of its bone {} is not finite, or it "
                    "names node {} of {}",
                    node_name(mesh.name), b, bone.node, nodes));
  }
  for (const double weight : mesh.weights) {
    if (std::isfinite(weight)) continue;
    return import_error(fmt::format("mesh '{}': one of its shapes has the weight {}",
                                    node_name(mesh.name), weight));
  }
  return {};
}

Status check_node(const FileScene& file, const FileNode& node) {
  for (const std::uint32_t mesh : node.meshes) {
    if (mesh < file.meshes.size()) continue;
    return import_error(fmt::format("node '{}' names mesh {}, but there are {}",
                                    node_name(node.name), mesh, file.meshes.size()));
  }
  for (std::size_t i = 0; i < node.parent_from_local.size(); ++i) {
    const double x = node.parent_from_local[i];
    if (std::isfinite(x)) continue;
    return import_error(fmt::format("node '{}': its transform holds {} in row {}, column {}",
                                    node_name(node.name), x, i / 4, i % 4));
  }
  return {};
}

template <class Value>
bool has_finite_tangents(const Track<Value>& track, std::size_t key) {
  return track.tangents.empty() ||
         (is_finite(track.tangents[key].in) && is_finite(track.tangents[key].out));
}

template <class Value>
Status check_track(const Track<Value>& track, const std::string& node) {
  double before = -HUGE_VAL;
  for (std::size_t i = 0; i < track.keys.size(); ++i) {
    const Key<Value>& key = track.keys[i];
    if (std::isfinite(key.seconds) && key.seconds >= before && is_finite(key.value) &&
        has_finite_tangents(track, i)) {
      before = key.seconds;
      continue;
    }
    return import_error(fmt::format(
        "node '{}': key {} of its animation, at {} s, is not finite or not in order of time", node,
        i, key.seconds));
  }
  return {};
}

Status check_animation(const FileScene& file, const Animation& animation) {
  if (!std::isfinite(animation.seconds)) {
    return import_error(
        fmt::format("animation '{}' lasts {} s", node_name(animation.name), animation.seconds));
  }
  for (const NodeChannel& channel : animation.channels) {
    const std::string name = node_name(file.nodes[channel.node].name);
    if (Status good = check_track(channel.positions, name); !good) return good;
    if (Status good = check_track(channel.rotations, name); !good) return good;
    if (Status good = check_track(channel.scalings, name); !good) return good;
  }
  for (const Deformation& deformation : animation.deformations) {
    const std::string name = node_name(file.nodes[deformation.node].name);
    if (Status good = check_track(deformation.weights, name); !good) return good;
  }
  return {};
}

Status check(const FileScene& file) {
  for (const FileMesh& mesh : file.meshes) {
    if (Status good = check_mesh(mesh, file.nodes.size()); !good) return good;
  }
  for (const FileNode& node : file.nodes) {
    if (Status good = check_node(file, node); !good) return good;
  }
  for (const Animation& animation : file.animations) {
    if (Status good = check_animation(file, animation); !good) return good;
  }
  return {};
}

struct ConvertedNodes {
  std::vector<ImportedNode> nodes;
  std::vector<std::uint32_t> source;     // each node's node in the file
  std::vector<std::uint32_t> converted;  // the node of each node in the file
};

ConvertedNodes convert_nodes(const std::vector<FileNode>& sources) {
  ConvertedNodes out;
  for (std::uint32_t i = 0; i < sources.size(); ++i) {
    const FileNode& source = sources[i];
    const auto index = static_cast<std::uint32_t>(out.nodes.size());
    out.converted.push_back(index);
    ImportedNode node;
    node.name = node_name(source.name);
    if (source.parent != kNone) node.parent = out.converted[source.parent];
    node.parent_from_local = source.parent_from_local;
    if (source.meshes.size() == 1) node.mesh = source.meshes[0];
    out.nodes.push_back(std::move(node));
    for (std::size_t k = 0; source.meshes.size() > 1 && k < source.meshes.size(); ++k) {
      ImportedNode child;
      child.name = node_name(source.name, fmt::format("#{}", k));
      child.parent = index;
      child.mesh = source.meshes[k];
      out.nodes.push_back(std::move(child));
    }
    out.source.resize(out.nodes.size(), i);
  }
  return out;
}

// The weights that the animation gives to a mesh of a node in the file.
Track<std::vector<double>> weights_of(const Animation& source, std::uint32_t node,
                                      std::uint32_t mesh) {
  for (const Deformation& deformation : source.deformations) {
    if (deformation.node == node && (deformation.mesh == mesh || deformation.mesh == kNone))
      return deformation.weights;
  }
  return {};
}

std::vector<Deformation> convert_deformations(const Animation& source, const FileScene& file,
                                              const ConvertedNodes& nodes) {
  std::vector<Deformation> out;
  for (std::uint32_t i = 0; i < nodes.nodes.size(); ++i) {
    const std::uint32_t mesh = nodes.nodes[i].mesh;
    if (mesh == kNone) continue;
    Deformation deformation{i, mesh, {}};
    if (!file.meshes[mesh].shapes.empty())
      deformation.weights = weights_of(source, nodes.source[i], mesh);
    if (!file.meshes[mesh].skin.bones.empty() || !deformation.weights.keys.empty())
      out.push_back(std::move(deformation));
  }
  return out;
}

std::vector<Animation> convert_animations(const FileScene& file, const ConvertedNodes& nodes) {
  std::vector<Animation> out;
  for (const Animation& source : file.animations) {
    Animation animation = source;
    animation.name = node_name(source.name);
    for (NodeChannel& channel : animation.channels) channel.node = nodes.converted[channel.node];
    animation.deformations = convert_deformations(source, file, nodes);
    const auto has_weights = [](const Deformation& d) { return !d.weights.keys.empty(); };
    if (!animation.channels.empty() ||
        std::any_of(animation.deformations.begin(), animation.deformations.end(), has_weights))
      out.push_back(std::move(animation));
  }
  return out;
}

// `vertices`: without a pose, as apply_rest_pose returns them.
Rig make_rig(const FileScene& file, const ConvertedNodes& nodes,
             std::vector<std::vector<Point>> vertices) {
  Rig rig;
  rig.vertices = std::move(vertices);
  for (const ImportedNode& node : nodes.nodes) {
    rig.parent_from_local.push_back(node.parent_from_local);
  }
  for (const FileMesh& mesh : file.meshes) {
    rig.shapes.push_back(mesh.shapes);
    rig.weights.push_back(mesh.weights);
    Skin& skin = rig.skins.emplace_back(mesh.skin);
    for (Skin::Bone& bone : skin.bones) bone.node = nodes.converted[bone.node];
    skin.first.resize(mesh.vertices.size() + 1);
  }
  return rig;
}

Status put_into_frame(ImportedScene& scene, const ImportOptions& options) {
  const double unit = scene.meters_per_unit;
  convert_frame(scene, options.up_axis, options.meters_per_unit);
  for (const ImportedNode& node : scene.nodes) {
    if (is_finite(node.parent_from_local)) continue;
    return import_error(
        fmt::format("node '{}': its transform is not finite once it is brought from {} m a "
                    "unit to {} m",
                    node.name, unit, scene.meters_per_unit));
  }
  return {};
}

Result<Rebased> move_near_origin(std::vector<FileMesh>& meshes, std::vector<ImportedNode>& nodes,
                                 const ImportOptions& options) {
  if (options.offsets.size() != meshes.size()) return rebase(meshes, nodes);
  return rebase_to(options.offsets, meshes, nodes);
}

std::vector<Vertex> rounded(const std::vector<Point>& points) {
  std::vector<Vertex> out;
  out.reserve(points.size());
  for (const Point& p : points) {
    out.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
  }
  return out;
}

// Counts polygons that intersect themselves. `number` is that of the mesh.
ImportedMesh convert_mesh(const FileMesh& source, std::size_t number, Warning& crossed) {
  ImportedMesh mesh;
  mesh.name = node_name(source.name);
  mesh.vertices = rounded(source.vertices);
  mesh.faces.reserve(source.faces.size());
  Triangulator triangulator(mesh.vertices);
  for (std::size_t f = 0; f < source.faces.size(); ++f) {
    const std::span<const std::uint32_t> corners = source.faces[f];
    if (corners.size() < 3) {
      mesh.faces.push_back({kNoVertex, kNoVertex, kNoVertex});
      ++mesh.lines_and_points;
      continue;
    }
    if (!triangulator.cut(corners, mesh.faces) && crossed.count++ == 0)
      crossed.first = fmt::format("mesh {} '{}', face {}", number, mesh.name, f);
    mesh.triangles += corners.size() - 2;
  }
  return mesh;
}

std::vector<ImportedMesh> convert_meshes(std::vector<FileMesh> sources,
                                         std::vector<Warning>& warnings) {
  std::vector<ImportedMesh> meshes;
  Warning crossed{.kind = "polygon_crosses_itself", .count = 0};
  for (FileMesh& source : sources) {
    meshes.push_back(convert_mesh(source, meshes.size(), crossed));
    source = {};
  }
  if (crossed.count == 0) return meshes;
  crossed.message = fmt::format(
      "{} of its polygons intersect themselves, or touch themselves thousands of times, the first "
      "in {}: parts of them are covered twice or not at all",
      crossed.count, crossed.first);
  warnings.push_back(std::move(crossed));
  return meshes;
}

}  // namespace

Result<AnimatedScene> scene_from_file(FileScene file, const ImportOptions& options) {
  if (const Status good = check(file); !good) return good.error();
  std::vector<std::vector<Point>> unposed = apply_rest_pose(file);
  ConvertedNodes nodes = convert_nodes(file.nodes);
  AnimatedScene out;
  out.animations = convert_animations(file, nodes);
  out.rig = make_rig(file, nodes, std::move(unposed));
  ImportedScene& scene = out.scene;
  scene.nodes = std::move(nodes.nodes);
  scene.up_axis = file.up_axis;
  scene.meters_per_unit = file.meters_per_unit;
  scene.warnings = std::move(file.warnings);
  out.rig.scene_from_file = frame_conversion(scene, options.up_axis, options.meters_per_unit);
  if (const Status good = put_into_frame(scene, options); !good) return good.error();
  auto rebased = move_near_origin(file.meshes, scene.nodes, options);
  if (!rebased) return rebased.error();
  out.rig.offsets = std::move(rebased->offsets);
  std::move(rebased->warnings.begin(), rebased->warnings.end(), std::back_inserter(scene.warnings));
  std::vector<bool> is_solid;
  is_solid.reserve(file.meshes.size());
  for (const FileMesh& mesh : file.meshes) is_solid.push_back(mesh.is_solid);
  scene.meshes = convert_meshes(std::move(file.meshes), scene.warnings);
  self_check(file.nodes, is_solid, scene);
  return out;
}

}  // namespace sightline::client::importer

// One check for each guarantee.
#include "client/importer/check_received.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "client/importer/node_name.h"

namespace sightline::client::importer {
namespace {

template <class Numbers>
bool all_finite(const Numbers& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
}

bool is_name(const std::string& name) { return node_name(name) == name; }

Status require(bool kept, const char* guarantee, std::size_t index) {
  if (kept) return {};
  return import_error(fmt::format("{} {}", guarantee, index));
}

bool is_good(const ImportedMesh& mesh) {
  std::uint64_t triangles = 0;
  for (const Face& face : mesh.faces) {
    if (face == Face{kNoVertex, kNoVertex, kNoVertex}) continue;
    ++triangles;
    for (const std::uint32_t vertex : face) {
      if (vertex >= mesh.vertices.size()) return false;
    }
  }
  const std::uint64_t others = mesh.faces.size() - triangles;
  return is_name(mesh.name) && mesh.triangles == triangles && mesh.lines_and_points == others;
}

bool is_good(const ImportedScene& scene, std::size_t index) {
  const ImportedNode& node = scene.nodes[index];
  return is_name(node.name) && (node.parent == kNone || node.parent < index) &&
         (node.mesh == kNone || node.mesh < scene.meshes.size()) &&
         all_finite(node.parent_from_local);
}

bool is_good(Beyond beyond) { return beyond <= Beyond::kRepeat; }

template <class Value>
bool is_good(const Track<Value>& track) {
  double before = -HUGE_VAL;
  for (const Key<Value>& key : track.keys) {
    if (!std::isfinite(key.seconds) || key.seconds < before || !all_finite(key.value)) return false;
    before = key.seconds;
  }
  const bool is_cubic = track.interpolation == Interpolation::kCubic;
  return is_good(track.before) && is_good(track.after) &&
         track.interpolation <= Interpolation::kCubic &&
         track.tangents.size() == (is_cubic ? track.keys.size() : 0) &&
         std::all_of(track.tangents.begin(), track.tangents.end(),
                     [](const auto& t) { return all_finite(t.in) && all_finite(t.out); });
}

bool is_good(const Skin& skin, const ImportedMesh& mesh, std::size_t nodes) {
  const bool bones = std::all_of(skin.bones.begin(), skin.bones.end(), [&](const Skin::Bone& bone) {
    return bone.node < nodes && all_finite(bone.bone_from_mesh);
  });
  const bool influences = std::all_of(
      skin.influences.begin(), skin.influences.end(), [&](const Skin::Influence& influence) {
        return influence.bone < skin.bones.size() && std::isfinite(influence.weight);
      });
  return bones && influences && skin.first.size() == mesh.vertices.size() + 1 &&
         skin.first.front() == 0 && skin.first.back() == skin.influences.size() &&
         std::is_sorted(skin.first.begin(), skin.first.end());
}

bool is_good(const Shapes& shapes, const ImportedMesh& mesh) {
  return std::all_of(shapes.begin(), shapes.end(),
                     [&](const auto& shape) { return shape.size() == mesh.vertices.size(); });
}

bool is_good(const NodeChannel& channel, std::size_t nodes) {
  return channel.node < nodes && !channel.positions.keys.empty() &&
         !channel.rotations.keys.empty() && !channel.scalings.keys.empty() &&
         is_good(channel.positions) && is_good(channel.rotations) && is_good(channel.scalings);
}

bool is_good(const Deformation& deformation, const AnimatedScene& animated) {
  const std::vector<ImportedNode>& nodes = animated.scene.nodes;
  if (deformation.node >= nodes.size() || deformation.mesh == kNone ||
      nodes[deformation.node].mesh != deformation.mesh || !is_good(deformation.weights))
    return false;
  const std::size_t shapes = animated.rig.shapes[deformation.mesh].size();
  const auto& keys = deformation.weights.keys;
  return std::all_of(keys.begin(), keys.end(),
                     [&](const auto& key) { return key.value.size() <= shapes; });
}

bool is_good(const Animation& animation, const AnimatedScene& animated) {
  return is_name(animation.name) && std::isfinite(animation.seconds) && animation.seconds >= 0 &&
         std::all_of(animation.channels.begin(), animation.channels.end(),
                     [&](const NodeChannel& channel) {
                       return is_good(channel, animated.scene.nodes.size());
                     }) &&
         std::all_of(animation.deformations.begin(), animation.deformations.end(),
                     [&](const Deformation& d) { return is_good(d, animated); });
}

Status check_rig(const AnimatedScene& animated) {
  const Rig& rig = animated.rig;
  const ImportedScene& scene = animated.scene;
  const bool transforms = rig.parent_from_local.size() == scene.nodes.size() &&
                          std::all_of(rig.parent_from_local.begin(), rig.parent_from_local.end(),
                                      [](const Transform& m) { return all_finite(m); });
  const bool lists =
      rig.vertices.size() == scene.meshes.size() && rig.skins.size() == scene.meshes.size() &&
      rig.shapes.size() == scene.meshes.size() && rig.weights.size() == scene.meshes.size() &&
      rig.offsets.size() == scene.meshes.size();
  const bool offsets = std::all_of(rig.offsets.begin(), rig.offsets.end(),
                                   [](const Point& offset) { return all_finite(offset); });
  if (!transforms || !lists || !offsets || !all_finite(rig.scene_from_file))
    return import_error("the rig");
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const ImportedMesh& mesh = scene.meshes[m];
    const bool is_rigid = rig.skins[m].bones.empty() && rig.shapes[m].empty();
    const bool good = is_good(rig.skins[m], mesh, scene.nodes.size()) &&
                      is_good(rig.shapes[m], mesh) && all_finite(rig.weights[m]) &&
                      rig.vertices[m].size() == (is_rigid ? 0 : mesh.vertices.size());
    if (Status kept = require(good, "the rig of mesh", m); !kept) return kept;
  }
  return {};
}

}  // namespace

Status check_received(const ImportedScene& scene) {
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    if (Status kept = require(is_good(scene.meshes[m]), "mesh", m); !kept) return kept;
  }
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (Status kept = require(is_good(scene, i), "node", i); !kept) return kept;
  }
  const bool frame = scene.up_axis <= UpAxis::kZ && scene.meters_per_unit >= 0 &&
                     std::isfinite(scene.meters_per_unit);
  if (!frame || scene.nodes.empty()) return import_error("the scene");
  return {};
}

Status check_received(const AnimatedScene& animated) {
  if (Status kept = check_received(animated.scene); !kept) return kept;
  if (Status kept = check_rig(animated); !kept) return kept;
  for (std::size_t a = 0; a < animated.animations.size(); ++a) {
    const bool good = is_good(animated.animations[a], animated);
    if (Status kept = require(good, "animation", a); !kept) return kept;
  }
  return {};
}

}  // namespace sightline::client::importer

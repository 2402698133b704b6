// Checks every guarantee of imported_scene.h and animation.h, one by one.
#include "tests/fuzz/importer/check_imported.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "client/calls/scene_check.h"
#include "client/importer/pose.h"

namespace sightline::tests {

using client::importer::AnimatedScene;
using client::importer::Animation;
using client::importer::ImportedMesh;
using client::importer::ImportedNode;
using client::importer::ImportedScene;
using client::importer::kNone;

namespace {

using Wrong = std::optional<std::string>;

template <class Numbers>
bool is_finite(const Numbers& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
}

/// Decodes and encodes each character, and compares.
bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const auto at = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
    const std::size_t length = at(0) < 0x80 ? 1 : at(0) < 0xE0 ? 2 : at(0) < 0xF0 ? 3 : 4;
    if (text.size() < length) return false;
    std::uint32_t code = length == 1 ? at(0) : at(0) & (0xFFU >> (length + 1));
    for (std::size_t i = 1; i < length; ++i) code = code << 6U | (at(i) & 0x3FU);
    std::string again;
    if (length == 1) again += static_cast<char>(code);
    for (std::size_t i = 0; length > 1 && i < length; ++i) {
      const std::uint32_t bits = code >> (6 * (length - 1 - i));
      again += static_cast<char>(i == 0 ? (0xF00U >> length & 0xFFU) | bits : 0x80U | (bits & 63U));
    }
    const std::uint32_t least = length == 1   ? 0
                                : length == 2 ? 0x80
                                : length == 3 ? 0x800
                                              : 0x10000;
    const bool is_surrogate = code >= 0xD800 && code < 0xE000;
    if (code < least || code > 0x10FFFF || is_surrogate || !text.starts_with(again)) return false;
    text.remove_prefix(length);
  }
  return true;
}

Wrong check_name(std::string_view name) {
  if (name.size() > client::importer::kMaxNodeName)
    return fmt::format("a name of {} bytes", name.size());
  if (!is_utf8(name)) return "a name that is not UTF-8";
  return {};
}

Wrong check_mesh(const ImportedMesh& mesh) {
  if (auto wrong = check_name(mesh.name)) return wrong;
  std::uint64_t triangles = 0;
  for (const client::Face& face : mesh.faces) {
    if (std::all_of(face.begin(), face.end(), [](auto v) { return v == client::kNoVertex; }))
      continue;
    ++triangles;
    for (const std::uint32_t v : face) {
      if (v >= mesh.vertices.size()) return fmt::format("vertex {} of {}", v, mesh.vertices.size());
    }
  }
  if (triangles != mesh.triangles || mesh.faces.size() != triangles + mesh.lines_and_points)
    return "faces do not add up";
  return {};
}

Wrong check_node(const ImportedScene& scene, std::size_t index) {
  const ImportedNode& node = scene.nodes[index];
  if (auto wrong = check_name(node.name)) return wrong;
  if (node.parent != kNone && node.parent >= index) return "a parent that is no earlier node";
  if (node.mesh != kNone && node.mesh >= scene.meshes.size()) return "a mesh that there is not";
  if (!is_finite(node.parent_from_local)) return "a transform that is not finite";
  return {};
}

template <class Value>
Wrong check_track(const client::importer::Track<Value>& track) {
  double before = -HUGE_VAL;
  for (const client::importer::Key<Value>& key : track.keys) {
    if (!std::isfinite(key.seconds) || key.seconds < before) return "keys out of order";
    if (!is_finite(key.value)) return "a key that is not finite";
    before = key.seconds;
  }
  return {};
}

Wrong check_skin(const client::importer::Skin& skin, const ImportedMesh& mesh, std::size_t nodes) {
  for (const client::importer::Skin::Bone& bone : skin.bones) {
    if (bone.node >= nodes || !is_finite(bone.bone_from_mesh)) return "a bad bone";
  }
  if (skin.bones.empty() && skin.influences.empty()) return {};
  if (skin.first.size() != mesh.vertices.size() + 1 || skin.first.front() != 0 ||
      skin.first.back() != skin.influences.size() ||
      !std::is_sorted(skin.first.begin(), skin.first.end()))
    return "influences are not by vertex";
  for (std::size_t v = 0; v + 1 < skin.first.size(); ++v) {
    double sum = 0;
    for (std::uint32_t i = skin.first[v]; i < skin.first[v + 1]; ++i) {
      if (skin.influences[i].bone >= skin.bones.size()) return "an influence of no bone";
      sum += skin.influences[i].weight;
    }
    if (skin.first[v] != skin.first[v + 1] && !(std::abs(sum - 1) < 1e-9))
      return fmt::format("weights that add up to {}", sum);
  }
  return {};
}

Wrong check_rig(const AnimatedScene& animated) {
  const client::importer::Rig& rig = animated.rig;
  const ImportedScene& scene = animated.scene;
  if (rig.parent_from_local.size() != scene.nodes.size()) return "a rig of other nodes";
  if (rig.skins.size() != scene.meshes.size() || rig.shapes.size() != scene.meshes.size())
    return "a rig of other meshes";
  if (!is_finite(rig.scene_from_file)) return "a frame not finite";
  if (rig.offsets.size() != scene.meshes.size()) return "offsets of other meshes";
  for (const auto& offset : rig.offsets) {
    if (!is_finite(offset)) return "an offset not finite";
  }
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    if (auto wrong = check_skin(rig.skins[m], scene.meshes[m], scene.nodes.size())) return wrong;
    for (const auto& shape : rig.shapes[m]) {
      if (shape.size() != scene.meshes[m].vertices.size()) return "a shape of other vertices";
    }
  }
  return {};
}

Wrong check_poses(const AnimatedScene& animated, const Animation& animation) {
  const double end = animation.seconds;
  for (const double seconds : {0.0, end / 3, end / 2, end, 1.5 * end, 1e9, -1.0}) {
    const client::importer::Pose pose = client::importer::pose(animated, animation, seconds);
    for (const client::importer::Pose::Placed& placed : pose.placed) {
      if (placed.node >= animated.scene.nodes.size()) return "a pose of no node";
    }
    for (const client::importer::Pose::Shaped& shaped : pose.shaped) {
      for (const std::uint32_t node : shaped.nodes) {
        if (node >= animated.scene.nodes.size()) return "a shape of no node";
        const std::uint32_t mesh = animated.scene.nodes[node].mesh;
        if (mesh == kNone || animated.scene.meshes[mesh].vertices.size() != shaped.vertices.size())
          return "a pose of other vertices";
      }
    }
  }
  return {};
}

Wrong check_animation(const AnimatedScene& animated, const Animation& animation) {
  if (auto wrong = check_name(animation.name)) return wrong;
  if (!std::isfinite(animation.seconds) || animation.seconds < 0)
    return fmt::format("an animation of {} s", animation.seconds);
  for (const client::importer::NodeChannel& channel : animation.channels) {
    if (channel.node >= animated.scene.nodes.size()) return "a channel of no node";
    if (channel.positions.keys.empty() || channel.rotations.keys.empty() ||
        channel.scalings.keys.empty())
      return "a track without keys";
    if (auto wrong = check_track(channel.positions)) return wrong;
    if (auto wrong = check_track(channel.rotations)) return wrong;
    if (auto wrong = check_track(channel.scalings)) return wrong;
  }
  for (const client::importer::Deformation& deformation : animation.deformations) {
    if (deformation.node >= animated.scene.nodes.size() ||
        animated.scene.nodes[deformation.node].mesh != deformation.mesh)
      return "a deformation of no mesh";
    if (auto wrong = check_track(deformation.weights)) return wrong;
  }
  return check_poses(animated, animation);
}

}  // namespace

std::optional<std::string> check_imported(const ImportedScene& scene) {
  for (const ImportedMesh& mesh : scene.meshes) {
    if (auto wrong = check_mesh(mesh)) return wrong;
  }
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (auto wrong = check_node(scene, i)) return wrong;
  }
  if (scene.nodes.empty()) return "no node";
  if (!(scene.meters_per_unit >= 0) || !std::isfinite(scene.meters_per_unit))
    return fmt::format("{} m a unit", scene.meters_per_unit);
  client::ServerInfo limits;
  limits.max_depth = 8;
  limits.max_triangles_per_mesh = 12;
  const client::Status uploadable = client::calls::check_scene(scene, limits);
  if (!uploadable && uploadable.error().message.empty()) return "refused without a word";
  return {};
}

std::optional<std::string> check_animated(const AnimatedScene& animated) {
  if (auto wrong = check_imported(animated.scene)) return wrong;
  if (auto wrong = check_rig(animated)) return wrong;
  for (const Animation& animation : animated.animations) {
    if (auto wrong = check_animation(animated, animation)) return wrong;
  }
  return {};
}

}  // namespace sightline::tests

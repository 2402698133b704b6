// Parts what nodes share, then poses each mesh once.
#include "client/importer/rest_pose.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "client/importer/affine.h"
#include "client/importer/deform.h"

namespace sightline::client::importer {
namespace {

// A transform with an inverse in double that is good for more than its last digits.
bool has_inverse(const Transform& m) {
  const Transform back = inverse(m) * m;
  for (std::size_t k = 0; k < 12; ++k) {
    if (!(std::abs(back[k] - kIdentity[k]) < 1e-3)) return false;
  }
  return true;
}

std::vector<Transform> world_of(const std::vector<FileNode>& nodes) {
  std::vector<Transform> world;
  world.reserve(nodes.size());
  for (const FileNode& node : nodes) {
    world.push_back(node.parent == kNone ? node.parent_from_local
                                         : world[node.parent] * node.parent_from_local);
  }
  return world;
}

// Whether a scale along some axis is 0 at a key, or may be between two of them.
bool may_vanish(const Track<Point>& scalings) {
  for (std::size_t k = 0; k < 3; ++k) {
    const bool is_negative = scalings.keys.front().value[k] < 0;
    for (const Key<Point>& key : scalings.keys) {
      if (key.value[k] == 0 || (key.value[k] < 0) != is_negative) return true;
    }
  }
  return scalings.interpolation == Interpolation::kCubic && scalings.keys.size() > 1;
}

// Whether each node's place in the scene has no inverse at rest, or at some time.
std::vector<bool> vanishing(const FileScene& scene, const std::vector<Transform>& world) {
  std::vector<bool> out(scene.nodes.size());
  for (const Animation& animation : scene.animations) {
    for (const NodeChannel& channel : animation.channels) {
      if (may_vanish(channel.scalings)) out[channel.node] = true;
    }
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::uint32_t parent = scene.nodes[i].parent;
    if ((parent != kNone && out[parent]) || !has_inverse(world[i])) out[i] = true;
  }
  return out;
}

class Parting {
 public:
  explicit Parting(FileScene& scene) : scene_(scene), is_taken_(scene.meshes.size()) {}

  // Nodes that are added have no parent, so that they are not looked at again.
  void part() {
    const std::vector<bool> vanishes = vanishing(scene_, world_of(scene_.nodes));
    for (std::uint32_t i = 0; i < vanishes.size(); ++i) {
      own_meshes(i);
      if (vanishes[i]) move_to_root(i);
    }
  }

 private:
  bool has_skin(std::uint32_t mesh) const { return !scene_.meshes[mesh].skin.bones.empty(); }

  void own_meshes(std::uint32_t node) {
    for (std::uint32_t& mesh : scene_.nodes[node].meshes) {
      if (!has_skin(mesh)) continue;
      if (is_taken_[mesh]) {
        const auto copy = static_cast<std::uint32_t>(scene_.meshes.size());
        scene_.meshes.push_back(FileMesh(scene_.meshes[mesh]));
        is_taken_.push_back(false);
        rename({node, mesh}, {node, copy});
        mesh = copy;
      }
      is_taken_[mesh] = true;
    }
  }

  void move_to_root(std::uint32_t node) {
    std::vector<std::uint32_t>& meshes = scene_.nodes[node].meshes;
    const auto first = std::stable_partition(meshes.begin(), meshes.end(),
                                             [&](std::uint32_t mesh) { return !has_skin(mesh); });
    if (first == meshes.end()) return;
    const auto moved = static_cast<std::uint32_t>(scene_.nodes.size());
    FileNode root;
    root.name = scene_.nodes[node].name;
    root.meshes.assign(first, meshes.end());
    meshes.erase(first, meshes.end());
    for (const std::uint32_t mesh : root.meshes) rename({node, mesh}, {moved, mesh});
    scene_.nodes.push_back(std::move(root));
    copy_deformations(node, moved);
  }

  struct NodeMesh {
    std::uint32_t node, mesh;
  };
  // Renames a node and a mesh in the deformations of that mesh.
  void rename(const NodeMesh& from, const NodeMesh& to) {
    for (Animation& animation : scene_.animations) {
      for (Deformation& deformation : animation.deformations) {
        if (deformation.node != from.node || deformation.mesh != from.mesh) continue;
        deformation.node = to.node;
        deformation.mesh = to.mesh;
      }
    }
  }

  // Copies the deformations that concern all meshes of a node: they concern the moved ones, too.
  void copy_deformations(std::uint32_t from, std::uint32_t to) {
    for (Animation& animation : scene_.animations) {
      const std::size_t count = animation.deformations.size();
      for (std::size_t i = 0; i < count; ++i) {
        Deformation copy = animation.deformations[i];
        if (copy.node != from || copy.mesh != kNone) continue;
        copy.node = to;
        animation.deformations.push_back(std::move(copy));
      }
    }
  }

  FileScene& scene_;
  std::vector<bool> is_taken_;  // whether a node has it, for each mesh with a skin
};

}  // namespace

std::vector<std::vector<Point>> apply_rest_pose(FileScene& scene) {
  Parting(scene).part();
  std::vector<std::vector<Point>> before(scene.meshes.size());
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    FileMesh& mesh = scene.meshes[m];
    if (mesh.skin.bones.empty() && mesh.shapes.empty()) continue;
    before[m] = mesh.vertices;
    blend(mesh.shapes, mesh.weights, mesh.vertices);
  }
  const std::vector<Transform> world = world_of(scene.nodes);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    for (const std::uint32_t m : scene.nodes[i].meshes) {
      FileMesh& mesh = scene.meshes[m];
      if (!mesh.skin.bones.empty()) put_on(mesh.skin, inverse(world[i]), world, mesh.vertices);
    }
  }
  return before;
}

}  // namespace sightline::client::importer

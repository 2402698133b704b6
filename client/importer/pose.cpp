// Computes transforms of nodes first, then vertices.
#include "client/importer/pose.h"

#include <cstddef>

#include "client/importer/affine.h"
#include "client/importer/deform.h"

namespace sightline::client::importer {
namespace {

// The transform in the file's own frame, which all functions below but `imported` use.
Transform local_at(const NodeChannel& channel, double seconds) {
  return compose(sample(channel.positions, seconds), sample(channel.rotations, seconds),
                 sample(channel.scalings, seconds));
}

std::vector<Transform> locals_at(const Rig& rig, const Animation& animation, double seconds) {
  std::vector<Transform> locals = rig.parent_from_local;
  for (const NodeChannel& channel : animation.channels) {
    locals[channel.node] = local_at(channel, seconds);
  }
  return locals;
}

std::vector<Transform> composed(const std::vector<ImportedNode>& nodes,
                                std::vector<Transform> transforms) {
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].parent != kNone) transforms[i] = transforms[nodes[i].parent] * transforms[i];
  }
  return transforms;
}

// Converts a transform from the file's frame to the frame of the scene.
Transform imported(const ImportedNode& node, const Rig& rig, const Transform& local) {
  Transform out = node.parent == kNone ? rig.scene_from_file * local : local;
  if (node.mesh == kNone) return out;
  const Point moved = out * rig.offsets[node.mesh];
  for (std::size_t r = 0; r < 3; ++r) out[4 * r + 3] = moved[r];
  return out;
}

// The points moved by the offset, and rounded.
std::vector<Vertex> rounded(const std::vector<Point>& points, const Point& offset) {
  std::vector<Vertex> vertices;
  vertices.reserve(points.size());
  for (const Point& p : points) {
    vertices.push_back({static_cast<float>(p[0] - offset[0]), static_cast<float>(p[1] - offset[1]),
                        static_cast<float>(p[2] - offset[2])});
  }
  return vertices;
}

}  // namespace

Pose pose(const AnimatedScene& animated, const Animation& animation, double seconds) {
  const Rig& rig = animated.rig;
  const ImportedScene& scene = animated.scene;
  const std::vector<Transform> locals = locals_at(rig, animation, seconds);
  Pose out;
  for (const NodeChannel& channel : animation.channels) {
    out.placed.push_back(
        {channel.node, imported(scene.nodes[channel.node], rig, locals[channel.node])});
  }
  if (animation.deformations.empty()) return out;
  const std::vector<Transform> world = composed(scene.nodes, locals);
  for (const Deformation& deformation : animation.deformations) {
    const std::uint32_t mesh = deformation.mesh;
    std::vector<Point> points = rig.vertices[mesh];
    blend(
        rig.shapes[mesh],
        deformation.weights.keys.empty() ? rig.weights[mesh] : sample(deformation.weights, seconds),
        points);
    const Skin& skin = rig.skins[mesh];
    if (!skin.bones.empty()) put_on(skin, inverse(world[deformation.node]), world, points);
    out.shaped.push_back({{deformation.node}, rounded(points, rig.offsets[mesh])});
  }
  return out;
}

}  // namespace sightline::client::importer

// Computes transforms of nodes first, then vertices.
#include "client/importer/pose.h"

#include <cmath>
#include <cstddef>

#include "client/importer/affine.h"

namespace sightline::client::importer {
namespace {

double invertible(double scale) {
  if (std::abs(scale) >= kLeastScale) return scale;
  return std::signbit(scale) ? -kLeastScale : kLeastScale;
}

// In the file's own frame, like all functions below except `imported`.
Transform local_at(const NodeChannel& channel, double seconds) {
  Point scaling = sample(channel.scalings, seconds);
  for (double& s : scaling) s = invertible(s);
  return compose(sample(channel.positions, seconds), sample(channel.rotations, seconds), scaling);
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
  const Point moved = out * rig.offset;
  for (std::size_t r = 0; r < 3; ++r) out[4 * r + 3] = moved[r];
  return out;
}

std::vector<Point> blended(std::vector<Point> points, const Shapes& shapes,
                           const Deformation& deformation, double seconds) {
  if (deformation.weights.keys.empty()) return points;
  const std::vector<double> weights = sample(deformation.weights, seconds);
  for (std::size_t s = 0; s < weights.size() && s < shapes.size(); ++s) {
    if (weights[s] == 0) continue;
    for (std::size_t v = 0; v < points.size(); ++v) {
      for (std::size_t k = 0; k < 3; ++k) {
        points[v][k] += weights[s] * static_cast<double>(shapes[s][v][k]);
      }
    }
  }
  return points;
}

void put_on(const Skin& skin, const Transform& mesh_from_world, const std::vector<Transform>& world,
            std::vector<Point>& points) {
  std::vector<Transform> follows;
  follows.reserve(skin.bones.size());
  for (const Skin::Bone& bone : skin.bones) {
    follows.push_back(mesh_from_world * world[bone.node] * bone.bone_from_mesh);
  }
  for (std::size_t v = 0; v < points.size(); ++v) {
    if (skin.first[v] == skin.first[v + 1]) continue;
    Point sum{};
    for (std::uint32_t i = skin.first[v]; i < skin.first[v + 1]; ++i) {
      const Point to = follows[skin.influences[i].bone] * points[v];
      for (std::size_t k = 0; k < 3; ++k) sum[k] += skin.influences[i].weight * to[k];
    }
    points[v] = sum;
  }
}

// Moved by the offset, and rounded.
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
    std::vector<Point> points =
        blended(rig.vertices[deformation.mesh], rig.shapes[deformation.mesh], deformation, seconds);
    const Skin& skin = rig.skins[deformation.mesh];
    if (!skin.bones.empty()) {
      put_on(skin, inverse(world[deformation.node]), world, points);
    }
    out.shaped.push_back({{deformation.node}, rounded(points, rig.offset)});
  }
  return out;
}

}  // namespace sightline::client::importer

// Converts names to indices of nodes, and ticks to seconds.
#include "client/importer/animation_from_assimp.h"

#include <assimp/anim.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <utility>

#include "client/importer/scene_from_assimp.h"
#include "client/importer/skin_from_assimp.h"

namespace sightline::client::importer {
namespace {

constexpr double kUsualTicksPerSecond = 25;  // Assimp's convention if the file states no rate

// Assimp's default is the node's own transform. glTF and Collada, which keep that default, both
// hold the nearest key.
Beyond beyond(aiAnimBehaviour behaviour) {
  if (behaviour == aiAnimBehaviour_LINEAR) return Beyond::kExtrapolate;
  if (behaviour == aiAnimBehaviour_REPEAT) return Beyond::kRepeat;
  return Beyond::kHold;
}

Point value_of(const aiVector3D& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

Quaternion value_of(const aiQuaternion& q) {
  Quaternion out{static_cast<double>(q.w), static_cast<double>(q.x), static_cast<double>(q.y),
                 static_cast<double>(q.z)};
  double square = 0;
  for (const double x : out) square += x * x;
  if (square == 0) return {1, 0, 0, 0};
  for (double& x : out) x /= std::sqrt(square);
  return out;
}

template <class Value>
bool is_finite(const Value& value) {
  return std::all_of(value.begin(), value.end(), [](double x) { return std::isfinite(x); });
}

template <class Value>
Status check(const Track<Value>& track, const std::string& node) {
  double before = -HUGE_VAL;
  for (std::size_t i = 0; i < track.keys.size(); ++i) {
    const Key<Value>& key = track.keys[i];
    if (std::isfinite(key.seconds) && key.seconds >= before && is_finite(key.value)) {
      before = key.seconds;
      continue;
    }
    return import_error(fmt::format(
        "node '{}': key {} of its animation, at {} s, is not finite or not in order of time", node,
        i, key.seconds));
  }
  return {};
}

class AnimationReader {
 public:
  AnimationReader(const aiScene& source, const ConvertedScene& converted)
      : source_(source), converted_(converted) {
    for (std::uint32_t i = 0; i < converted.sources.size(); ++i) {
      if (converted.sources[i] != nullptr) {
        nodes_.emplace(converted.sources[i]->mName.C_Str(), i);
      }
    }
  }

  Result<Rig> rig() const {
    Rig rig;
    for (const ImportedNode& node : converted_.scene.nodes) {
      rig.parent_from_local.push_back(node.parent_from_local);
    }
    for (unsigned m = 0; m < source_.mNumMeshes; ++m) {
      auto skin = skin_from_assimp(*source_.mMeshes[m], nodes_);
      if (!skin) return skin.error();
      rig.skins.push_back(*std::move(skin));
      auto shapes = shapes_from_assimp(*source_.mMeshes[m]);
      if (!shapes) return shapes.error();
      rig.shapes.push_back(*std::move(shapes));
    }
    return rig;
  }

  Result<Animation> read(const aiAnimation& source) const {
    Animation animation;
    animation.name = node_name(source.mName.C_Str());
    const double rate = source.mTicksPerSecond > 0 ? source.mTicksPerSecond : kUsualTicksPerSecond;
    if (const Status read = read_channels(source, rate, animation); !read) return read.error();
    if (const Status read = read_deformations(source, rate, animation); !read) return read.error();
    const double seconds = source.mDuration / rate;
    if (!std::isfinite(seconds)) {
      return import_error(fmt::format("animation '{}' lasts {} s", animation.name, seconds));
    }
    animation.seconds = std::max(animation.seconds, seconds);
    return animation;
  }

 private:
  template <class Value, class SourceKey>
  static Track<Value> track(const SourceKey* keys, unsigned count, double rate,
                            Animation& animation) {
    Track<Value> track;
    for (unsigned i = 0; i < count; ++i) {
      track.keys.push_back({keys[i].mTime / rate, value_of(keys[i].mValue)});
      animation.seconds = std::max(animation.seconds, track.keys.back().seconds);
    }
    return track;
  }

  // Fills the tracks that a channel leaves out with the node's transform at rest.
  static void complete(const aiNode& node, NodeChannel& channel) {
    aiVector3D scaling, position;
    aiQuaternion rotation;
    node.mTransformation.Decompose(scaling, rotation, position);
    if (channel.positions.keys.empty()) channel.positions.keys = {{0, value_of(position)}};
    if (channel.rotations.keys.empty()) channel.rotations.keys = {{0, value_of(rotation)}};
    if (channel.scalings.keys.empty()) channel.scalings.keys = {{0, value_of(scaling)}};
  }

  static Result<NodeChannel> read(const aiNodeAnim& source, const aiNode& node, double rate,
                                  Animation& animation) {
    NodeChannel channel;
    channel.positions =
        track<Point>(source.mPositionKeys, source.mNumPositionKeys, rate, animation);
    channel.rotations =
        track<Quaternion>(source.mRotationKeys, source.mNumRotationKeys, rate, animation);
    channel.scalings = track<Point>(source.mScalingKeys, source.mNumScalingKeys, rate, animation);
    complete(node, channel);
    const auto set = [&](auto& track) {
      track.before = beyond(source.mPreState);
      track.after = beyond(source.mPostState);
      return check(track, node.mName.C_Str());
    };
    if (const Status good = set(channel.positions); !good) return good.error();
    if (const Status good = set(channel.rotations); !good) return good.error();
    if (const Status good = set(channel.scalings); !good) return good.error();
    return channel;
  }

  // A channel whose name is no node, for example a camera, is ignored.
  Status read_channels(const aiAnimation& source, double rate, Animation& animation) const {
    std::set<std::uint32_t> seen;
    for (unsigned i = 0; i < source.mNumChannels; ++i) {
      const auto node = nodes_.find(source.mChannels[i]->mNodeName.C_Str());
      if (node == nodes_.end() || !seen.insert(node->second).second) continue;
      auto channel = read(*source.mChannels[i], *converted_.sources[node->second], rate, animation);
      if (!channel) return channel.error();
      channel->node = node->second;
      animation.channels.push_back(*std::move(channel));
    }
    return {};
  }

  // Weights of the first `shapes` shapes. Weights of shapes that do not exist are ignored.
  static Track<std::vector<double>> weights(const aiMeshMorphAnim& source, std::size_t shapes,
                                            double rate, Animation& animation) {
    Track<std::vector<double>> track;
    for (unsigned i = 0; i < source.mNumKeys; ++i) {
      const aiMeshMorphKey& key = source.mKeys[i];
      std::vector<double> weights;
      for (unsigned k = 0; k < key.mNumValuesAndWeights; ++k) {
        const std::size_t shape = key.mValues[k];
        if (shape >= shapes) continue;
        if (weights.size() <= shape) weights.resize(shape + 1);
        weights[shape] = key.mWeights[k];
      }
      track.keys.push_back({key.mTime / rate, std::move(weights)});
      animation.seconds = std::max(animation.seconds, track.keys.back().seconds);
    }
    return track;
  }

  // The channel of a node's shapes. Its name is that of the node or of the mesh.
  static const aiMeshMorphAnim* channel_for(const aiAnimation& source, const aiNode& node,
                                            const aiMesh& mesh) {
    for (unsigned i = 0; i < source.mNumMorphMeshChannels; ++i) {
      const aiString& name = source.mMorphMeshChannels[i]->mName;
      if (name == node.mName || name == mesh.mName) return source.mMorphMeshChannels[i];
    }
    return nullptr;
  }

  Status read_deformations(const aiAnimation& source, double rate, Animation& animation) const {
    const std::vector<ImportedNode>& nodes = converted_.scene.nodes;
    for (std::uint32_t i = 0; i < nodes.size(); ++i) {
      if (nodes[i].mesh == kNone) continue;
      const aiMesh& mesh = *source_.mMeshes[nodes[i].mesh];
      const aiNode& node =
          *converted_.sources[converted_.sources[i] != nullptr ? i : nodes[i].parent];
      Deformation deformation{i, nodes[i].mesh, {}};
      const aiMeshMorphAnim* shapes =
          mesh.mNumAnimMeshes > 0 ? channel_for(source, node, mesh) : nullptr;
      if (shapes != nullptr) {
        deformation.weights = weights(*shapes, mesh.mNumAnimMeshes, rate, animation);
      }
      if (Status good = check(deformation.weights, nodes[i].name); !good) return good;
      if (mesh.mNumBones > 0 || !deformation.weights.keys.empty())
        animation.deformations.push_back(std::move(deformation));
    }
    return {};
  }

  const aiScene& source_;
  const ConvertedScene& converted_;
  NodesByName nodes_;
};

}  // namespace

Result<AnimatedScene> animation_from_assimp(const aiScene& source, ConvertedScene converted) {
  const AnimationReader reader(source, converted);
  AnimatedScene out;
  auto rig = reader.rig();
  if (!rig) return rig.error();
  out.rig = *std::move(rig);
  for (unsigned i = 0; i < source.mNumAnimations; ++i) {
    auto animation = reader.read(*source.mAnimations[i]);
    if (!animation) return animation.error();
    const bool has_shapes =
        std::any_of(animation->deformations.begin(), animation->deformations.end(),
                    [](const Deformation& d) { return !d.weights.keys.empty(); });
    if (!animation->channels.empty() || has_shapes) out.animations.push_back(*std::move(animation));
  }
  out.scene = std::move(converted.scene);
  return out;
}

}  // namespace sightline::client::importer

// Converts names to indices of nodes, and ticks to seconds.
#include "client/importer/animation_from_assimp.h"

#include <assimp/anim.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <utility>

namespace sightline::client::importer {
namespace {

constexpr double kUsualTicksPerSecond = 25;  // Assimp's convention if the file states no rate

// Assimp's default is the node's own transform. Collada, which keeps that default, holds the
// nearest key.
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

class AnimationReader {
 public:
  AnimationReader(const aiScene& source, const std::vector<const aiNode*>& nodes,
                  const NodesByName& by_name)
      : source_(source), nodes_(nodes), by_name_(by_name) {}

  Animation read(const aiAnimation& source) const {
    Animation animation;
    animation.name = source.mName.C_Str();
    const double rate = source.mTicksPerSecond > 0 ? source.mTicksPerSecond : kUsualTicksPerSecond;
    read_channels(source, rate, animation);
    read_deformations(source, rate, animation);
    const double seconds = source.mDuration / rate;
    animation.seconds = std::isfinite(seconds) ? std::max(animation.seconds, seconds) : seconds;
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

  static NodeChannel read(const aiNodeAnim& source, const aiNode& node, double rate,
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
    };
    set(channel.positions);
    set(channel.rotations);
    set(channel.scalings);
    return channel;
  }

  // A channel whose name is no node, for example a camera, is ignored.
  void read_channels(const aiAnimation& source, double rate, Animation& animation) const {
    std::set<std::uint32_t> seen;
    for (unsigned i = 0; i < source.mNumChannels; ++i) {
      const auto node = by_name_.find(source.mChannels[i]->mNodeName.C_Str());
      if (node == by_name_.end() || !seen.insert(node->second).second) continue;
      NodeChannel channel = read(*source.mChannels[i], *nodes_[node->second], rate, animation);
      channel.node = node->second;
      animation.channels.push_back(std::move(channel));
    }
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

  void read_deformations(const aiAnimation& source, double rate, Animation& animation) const {
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
      for (unsigned k = 0; k < nodes_[i]->mNumMeshes; ++k) {
        const unsigned m = nodes_[i]->mMeshes[k];
        if (m >= source_.mNumMeshes || source_.mMeshes[m]->mNumAnimMeshes == 0) continue;
        const aiMesh& mesh = *source_.mMeshes[m];
        const aiMeshMorphAnim* const shapes = channel_for(source, *nodes_[i], mesh);
        if (shapes == nullptr) continue;
        animation.deformations.push_back(
            {i, m, weights(*shapes, mesh.mNumAnimMeshes, rate, animation)});
      }
    }
  }

  const aiScene& source_;
  const std::vector<const aiNode*>& nodes_;
  const NodesByName& by_name_;
};

}  // namespace

std::vector<Animation> animations_from_assimp(const aiScene& source,
                                              const std::vector<const aiNode*>& nodes,
                                              const NodesByName& by_name) {
  const AnimationReader reader(source, nodes, by_name);
  std::vector<Animation> out;
  for (unsigned i = 0; i < source.mNumAnimations; ++i) {
    out.push_back(reader.read(*source.mAnimations[i]));
  }
  return out;
}

}  // namespace sightline::client::importer

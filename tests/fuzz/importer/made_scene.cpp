// Reads counts first, then the counted elements.
#include "tests/fuzz/importer/made_scene.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "tests/fuzz/hostile_number.h"

namespace sightline::tests {
namespace {

aiVector3D take_ai_vector(Bytes& bytes) {
  const float x = take_float(bytes), y = take_float(bytes), z = take_float(bytes);
  return {x, y, z};
}

aiMatrix4x4 take_matrix(Bytes& bytes) {
  aiMatrix4x4 matrix;
  const std::size_t kind = bytes.below(8);
  if (kind == 0) return matrix;
  const unsigned rows = kind < 6 ? 3 : 4;
  for (unsigned r = 0; r < rows; ++r) {
    for (unsigned c = 0; c < 4; ++c) {
      // Some only translate and scale.
      if (kind < 4 && c != 3 && c != r) continue;
      matrix[r][c] = take_float(bytes);
    }
  }
  return matrix;
}

/// Usually below `count`, sometimes any number.
unsigned take_index(Bytes& bytes, unsigned count) {
  const auto kind = bytes.take<std::uint8_t>();
  if (kind < 240) return count == 0 ? 0 : kind % count;
  if (kind < 248) return count + (kind - 240U);
  return bytes.take<std::uint32_t>();
}

aiString take_name(Bytes& bytes) {
  static const std::string kNames[] = {"",
                                       "a",
                                       "b",
                                       "c",
                                       "a#0",
                                       "\xC3\xA9",
                                       "\xE9t\xE9",
                                       "\xF0\x9F\x98",
                                       "\xED\xA0\x80",
                                       std::string("a\0b", 3),
                                       std::string(1023, 'n'),
                                       std::string(1022, 'n') + "\xE9",
                                       std::string(1023, '\xE9'),
                                       "$AssimpFbx$_Pre"};
  const std::size_t kind = bytes.below(std::size(kNames) + 4);
  if (kind < std::size(kNames)) return aiString(kNames[kind]);
  std::string name;
  for (std::size_t left = bytes.below(8); left > 0; --left) {
    name += static_cast<char>(bytes.take<std::uint8_t>());
  }
  return aiString(name);
}

/// Null if empty. An array of pointers, as most of Assimp's arrays are.
template <class T, class Make>
T** make_pointers(unsigned count, const Make& make) {
  if (count == 0) return nullptr;
  T** const all = new T*[count];
  for (unsigned i = 0; i < count; ++i) all[i] = make();
  return all;
}

class SceneMaker {
 public:
  explicit SceneMaker(Bytes& bytes) : bytes_(bytes) {}

  std::unique_ptr<aiScene> make() {
    auto scene = std::make_unique<aiScene>();
    scene->mNumMeshes = count(5);
    scene->mMeshes = make_pointers<aiMesh>(scene->mNumMeshes, [&] { return make_mesh(); });
    scene->mRootNode = make_nodes(scene->mNumMeshes);
    scene->mNumAnimations = count(4);
    scene->mAnimations =
        make_pointers<aiAnimation>(scene->mNumAnimations, [&] { return make_animation(); });
    return scene;
  }

 private:
  unsigned count(std::size_t below) { return static_cast<unsigned>(bytes_.below(below)); }
  bool rarely() { return bytes_.take<std::uint8_t>() >= 250; }

  aiVector3D* make_vectors(unsigned n) {
    auto* const all = new aiVector3D[n];
    for (unsigned i = 0; i < n; ++i) all[i] = take_ai_vector(bytes_);
    return all;
  }

  void make_face(unsigned vertices, aiFace& face) {
    face.mNumIndices = bytes_.below(4) > 0 ? 3 : count(7);
    face.mIndices = new unsigned[face.mNumIndices];
    for (unsigned k = 0; k < face.mNumIndices; ++k) face.mIndices[k] = take_index(bytes_, vertices);
  }

  aiBone* make_bone(unsigned vertices) {
    auto* const bone = new aiBone;
    bone->mName = take_name(bytes_);
    bone->mOffsetMatrix = take_matrix(bytes_);
    bone->mNumWeights = count(6);
    bone->mWeights = new aiVertexWeight[bone->mNumWeights];
    for (unsigned i = 0; i < bone->mNumWeights; ++i) {
      bone->mWeights[i].mVertexId = take_index(bytes_, vertices);
      bone->mWeights[i].mWeight = take_float(bytes_);
    }
    return bone;
  }

  aiAnimMesh* make_shape(unsigned vertices) {
    auto* const shape = new aiAnimMesh;
    shape->mNumVertices = rarely() ? count(20) : vertices;
    if (!rarely()) shape->mVertices = make_vectors(shape->mNumVertices);
    return shape;
  }

  aiMesh* make_mesh() {
    auto* const mesh = new aiMesh;
    mesh->mName = take_name(bytes_);
    mesh->mNumVertices = count(16);
    if (!rarely()) mesh->mVertices = make_vectors(mesh->mNumVertices);
    mesh->mNumFaces = count(16);
    mesh->mFaces = new aiFace[mesh->mNumFaces];
    for (unsigned i = 0; i < mesh->mNumFaces; ++i) make_face(mesh->mNumVertices, mesh->mFaces[i]);
    const unsigned more = count(8);
    mesh->mNumBones = more & 3U;
    mesh->mBones =
        make_pointers<aiBone>(mesh->mNumBones, [&] { return make_bone(mesh->mNumVertices); });
    mesh->mNumAnimMeshes = more >> 2U;
    mesh->mAnimMeshes = make_pointers<aiAnimMesh>(mesh->mNumAnimMeshes,
                                                  [&] { return make_shape(mesh->mNumVertices); });
    if (rarely()) mesh->mMethod = aiMorphingMethod_MORPH_RELATIVE;
    return mesh;
  }

  aiNode* make_node(unsigned meshes) {
    auto* const node = new aiNode;
    node->mName = take_name(bytes_);
    node->mTransformation = take_matrix(bytes_);
    node->mNumMeshes = count(4);
    node->mMeshes = new unsigned[node->mNumMeshes];
    for (unsigned i = 0; i < node->mNumMeshes; ++i) {
      node->mMeshes[i] = take_index(bytes_, meshes);
    }
    return node;
  }

  aiNode* make_nodes(unsigned meshes) {
    std::vector<aiNode*> nodes{make_node(meshes)};
    for (unsigned left = count(12); left > 0; --left) {
      aiNode* child = make_node(meshes);
      nodes[bytes_.below(nodes.size())]->addChildren(1, &child);
      nodes.push_back(child);
    }
    return nodes.front();
  }

  aiNodeAnim* make_channel() {
    auto* const channel = new aiNodeAnim;
    channel->mNodeName = take_name(bytes_);
    channel->mPreState = static_cast<aiAnimBehaviour>(count(4));
    channel->mPostState = static_cast<aiAnimBehaviour>(count(4));
    const auto key_vectors = [&](unsigned& n, aiVectorKey*& keys) {
      n = count(4);
      keys = n == 0 ? nullptr : new aiVectorKey[n];
      for (unsigned i = 0; i < n; ++i) keys[i] = {take_time(i), take_ai_vector(bytes_)};
    };
    key_vectors(channel->mNumPositionKeys, channel->mPositionKeys);
    key_vectors(channel->mNumScalingKeys, channel->mScalingKeys);
    channel->mNumRotationKeys = count(4);
    if (channel->mNumRotationKeys == 0) return channel;
    channel->mRotationKeys = new aiQuatKey[channel->mNumRotationKeys];
    for (unsigned i = 0; i < channel->mNumRotationKeys; ++i) {
      const float w = take_float(bytes_), x = take_float(bytes_), y = take_float(bytes_);
      channel->mRotationKeys[i] = {take_time(i), aiQuaternion(w, x, y, take_float(bytes_))};
    }
    return channel;
  }

  /// Usually in order.
  double take_time(unsigned key) {
    const auto kind = bytes_.take<std::uint8_t>();
    return kind < 192 ? static_cast<double>(key) * (kind + 1) : take_double(bytes_);
  }

  aiMeshMorphAnim* make_weights() {
    auto* const channel = new aiMeshMorphAnim;
    channel->mName = take_name(bytes_);
    channel->mNumKeys = count(4);
    channel->mKeys = new aiMeshMorphKey[channel->mNumKeys];
    for (unsigned i = 0; i < channel->mNumKeys; ++i) {
      aiMeshMorphKey& key = channel->mKeys[i];
      key.mTime = take_time(i);
      key.mNumValuesAndWeights = count(4);
      if (key.mNumValuesAndWeights == 0) continue;
      key.mValues = new unsigned[key.mNumValuesAndWeights];
      key.mWeights = new double[key.mNumValuesAndWeights];
      for (unsigned k = 0; k < key.mNumValuesAndWeights; ++k) {
        key.mValues[k] = take_index(bytes_, 2);
        key.mWeights[k] = take_double(bytes_);
      }
    }
    return channel;
  }

  aiAnimation* make_animation() {
    auto* const animation = new aiAnimation;
    animation->mName = take_name(bytes_);
    animation->mDuration = take_double(bytes_);
    animation->mTicksPerSecond = take_double(bytes_);
    animation->mNumChannels = count(4);
    animation->mChannels =
        make_pointers<aiNodeAnim>(animation->mNumChannels, [&] { return make_channel(); });
    animation->mNumMorphMeshChannels = count(3);
    animation->mMorphMeshChannels = make_pointers<aiMeshMorphAnim>(animation->mNumMorphMeshChannels,
                                                                   [&] { return make_weights(); });
    return animation;
  }

  Bytes& bytes_;
};

void describe_frame(Bytes& bytes, aiScene& scene) {
  scene.mMetaData = new aiMetadata;
  scene.mMetaData->Add("UpAxis", static_cast<std::int32_t>(bytes.below(4)));
  if (bytes.below(2) == 0) {
    scene.mMetaData->Add("UnitScaleFactor", take_double(bytes));
  } else {
    scene.mMetaData->Add("UnitScaleFactor", take_float(bytes));
  }
}

client::importer::ImportOptions take_options(Bytes& bytes) {
  client::importer::ImportOptions options;
  const std::size_t up = bytes.below(4);
  if (up == 1) options.up_axis = client::UpAxis::kY;
  if (up == 2) options.up_axis = client::UpAxis::kZ;
  if (bytes.below(2) == 0) return options;
  const double unit = take_double(bytes);
  if (unit > 0 && unit <= std::numeric_limits<double>::max()) options.meters_per_unit = unit;
  return options;
}

}  // namespace

MadeScene make_scene(Bytes bytes) {
  static constexpr const char* kImporters[] = {"", "glTF2 Importer", "Collada Importer",
                                               "Autodesk FBX Importer"};
  MadeScene made;
  made.importer_name = kImporters[bytes.below(std::size(kImporters))];
  made.options = take_options(bytes);
  const bool has_frame = bytes.below(2) == 1;
  made.scene = SceneMaker(bytes).make();
  if (has_frame) describe_frame(bytes, *made.scene);
  return made;
}

}  // namespace sightline::tests

// Regroups weights from bones to vertices.
#include "client/importer/skin_from_assimp.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>

#include "client/importer/file_scene_from_assimp.h"

namespace sightline::client::importer {
namespace {

Status check(const aiMesh& mesh, const aiBone& bone) {
  for (unsigned i = 0; i < bone.mNumWeights; ++i) {
    const aiVertexWeight& weight = bone.mWeights[i];
    if (weight.mVertexId < mesh.mNumVertices && std::isfinite(weight.mWeight) &&
        weight.mWeight >= 0)
      continue;
    return import_error(fmt::format("mesh '{}': bone '{}' has weight {} for vertex {} of {}",
                                    mesh.mName.C_Str(), bone.mName.C_Str(), weight.mWeight,
                                    weight.mVertexId, mesh.mNumVertices));
  }
  return {};
}

template <class Use>
void each_weight(const aiMesh& mesh, const Use& use) {
  for (unsigned b = 0; b < mesh.mNumBones; ++b) {
    const aiBone& bone = *mesh.mBones[b];
    for (unsigned i = 0; i < bone.mNumWeights; ++i) {
      const aiVertexWeight& weight = bone.mWeights[i];
      if (weight.mWeight > 0) use(weight.mVertexId, b, static_cast<double>(weight.mWeight));
    }
  }
}

void gather(const aiMesh& mesh, Skin& skin) {
  std::vector<double> sums(mesh.mNumVertices);
  skin.first.assign(std::size_t{mesh.mNumVertices} + 1, 0);
  each_weight(mesh, [&](unsigned vertex, unsigned, double weight) {
    ++skin.first[vertex + std::size_t{1}];
    sums[vertex] += weight;
  });
  for (std::size_t v = 0; v < mesh.mNumVertices; ++v) skin.first[v + 1] += skin.first[v];
  skin.influences.resize(skin.first.back());
  std::vector<std::uint32_t> next = skin.first;
  each_weight(mesh, [&](unsigned vertex, unsigned bone, double weight) {
    skin.influences[next[vertex]++] = {bone, weight / sums[vertex]};
  });
}

}  // namespace

Result<Skin> skin_from_assimp(const aiMesh& mesh, const NodesByName& nodes) {
  Skin skin;
  for (unsigned b = 0; b < mesh.mNumBones; ++b) {
    const aiBone& bone = *mesh.mBones[b];
    const auto node = nodes.find(bone.mName.C_Str());
    if (node == nodes.end()) {
      return import_error(fmt::format("mesh '{}': its bone '{}' is no node of the file",
                                      mesh.mName.C_Str(), bone.mName.C_Str()));
    }
    if (const Status good = check(mesh, bone); !good) return good.error();
    skin.bones.push_back({node->second, transform_from_assimp(bone.mOffsetMatrix)});
  }
  gather(mesh, skin);
  return skin;
}

Result<Shapes> shapes_from_assimp(const aiMesh& mesh) {
  Shapes shapes;
  for (unsigned s = 0; s < mesh.mNumAnimMeshes; ++s) {
    const aiAnimMesh& target = *mesh.mAnimMeshes[s];
    auto& shape = shapes.emplace_back(mesh.mNumVertices);
    if (target.mVertices == nullptr) continue;
    if (target.mNumVertices != mesh.mNumVertices) {
      return import_error(fmt::format("mesh '{}': shape {} has {} vertices, the mesh {}",
                                      mesh.mName.C_Str(), s, target.mNumVertices,
                                      mesh.mNumVertices));
    }
    // Targets that Assimp calls relative are offsets already.
    const bool is_relative = mesh.mMethod == aiMorphingMethod_MORPH_RELATIVE;
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D far =
          is_relative ? target.mVertices[v] : target.mVertices[v] - mesh.mVertices[v];
      shape[v] = {far.x, far.y, far.z};
    }
  }
  return shapes;
}

}  // namespace sightline::client::importer

// Converts nodes first, depth first, because skins and animations name them.
#include "client/importer/file_scene_from_assimp.h"

#include <assimp/mesh.h>
#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <utility>

#include "client/importer/animation_from_assimp.h"
#include "client/importer/frame.h"
#include "client/importer/node_name.h"
#include "client/importer/skin_from_assimp.h"

namespace sightline::client::importer {
namespace {

Point point(const aiVector3D& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

Result<FileMesh> convert(const aiMesh& source, const NodesByName& nodes) {
  FileMesh mesh;
  mesh.name = source.mName.C_Str();
  if (source.mNumVertices > 0 && !source.HasPositions()) {
    return import_error(fmt::format("mesh '{}' has {} vertices and no positions",
                                    node_name(mesh.name), source.mNumVertices));
  }
  mesh.vertices.reserve(source.mNumVertices);
  for (unsigned i = 0; i < source.mNumVertices; ++i) {
    mesh.vertices.push_back(point(source.mVertices[i]));
  }
  Polygons& faces = mesh.faces;
  faces.first.reserve(source.mNumFaces + std::size_t{1});
  for (unsigned i = 0; i < source.mNumFaces; ++i) {
    const aiFace& face = source.mFaces[i];
    faces.corners.insert(faces.corners.end(), face.mIndices, face.mIndices + face.mNumIndices);
    faces.first.push_back(static_cast<std::uint32_t>(faces.corners.size()));
  }
  auto skin = skin_from_assimp(source, nodes);
  if (!skin) return skin.error();
  mesh.skin = *std::move(skin);
  auto shapes = shapes_from_assimp(source);
  if (!shapes) return shapes.error();
  mesh.shapes = *std::move(shapes);
  for (unsigned s = 0; s < source.mNumAnimMeshes; ++s)
    mesh.weights.push_back(static_cast<double>(source.mAnimMeshes[s]->mWeight));
  return mesh;
}

// Depth first, children in order. No recursion, because files determine the depth.
std::vector<const aiNode*> add_nodes(const aiNode& root, std::vector<FileNode>& nodes) {
  std::vector<const aiNode*> sources;
  std::vector<std::pair<const aiNode*, std::uint32_t>> open{{&root, kNone}};
  while (!open.empty()) {
    const auto [source, parent] = open.back();
    open.pop_back();
    const auto index = static_cast<std::uint32_t>(nodes.size());
    sources.push_back(source);
    nodes.push_back({source->mName.C_Str(),
                     parent,
                     transform_from_assimp(source->mTransformation),
                     {source->mMeshes, source->mMeshes + source->mNumMeshes}});
    for (unsigned k = source->mNumChildren; k-- > 0;) {
      open.emplace_back(source->mChildren[k], index);
    }
  }
  return sources;
}

}  // namespace

Transform transform_from_assimp(const aiMatrix4x4& m) {
  Transform rows{};
  for (unsigned r = 0; r < 3; ++r) {
    for (unsigned c = 0; c < 4; ++c) rows[r * std::size_t{4} + c] = static_cast<double>(m[r][c]);
  }
  return rows;
}

Result<FileScene> file_scene_from_assimp(const aiScene& source, std::string_view importer_name) {
  FileScene out;
  const std::vector<const aiNode*> sources = add_nodes(*source.mRootNode, out.nodes);
  NodesByName by_name;
  for (std::uint32_t i = 0; i < sources.size(); ++i) {
    by_name.emplace(sources[i]->mName.C_Str(), i);
  }
  out.meshes.reserve(source.mNumMeshes);
  for (unsigned i = 0; i < source.mNumMeshes; ++i) {
    auto mesh = convert(*source.mMeshes[i], by_name);
    if (!mesh) return mesh.error();
    out.meshes.push_back(*std::move(mesh));
  }
  out.animations = animations_from_assimp(source, sources, by_name);
  const Frame frame = frame_of(source, importer_name);
  out.up_axis = frame.up_axis;
  out.meters_per_unit = frame.meters_per_unit;
  return out;
}

}  // namespace sightline::client::importer

// Meshes, then nodes, depth first.
#include "client/importer/scene_from_assimp.h"

#include <assimp/mesh.h>
#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <utility>

#include "client/importer/node_name.h"

namespace sightline::client::importer {
namespace {

Error invalid(std::string message) { return {Code::kInvalidArgument, std::move(message), {}}; }

// A face of one or two corners is a point or a line; Assimp leaves a polygon whole where it cannot
// cut it.
void add_face(const aiFace& face, ImportedMesh& mesh) {
  if (face.mNumIndices == 3) {
    mesh.faces.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
    ++mesh.triangles;
    return;
  }
  mesh.faces.push_back({kNoVertex, kNoVertex, kNoVertex});
  ++(face.mNumIndices < 3 ? mesh.lines_and_points : mesh.uncut_polygons);
}

Result<ImportedMesh> convert(const aiMesh& source) {
  ImportedMesh mesh;
  mesh.name = node_name(source.mName.C_Str());
  if (source.mNumVertices > 0 && !source.HasPositions()) {
    return invalid(
        fmt::format("mesh '{}' has {} vertices and no positions", mesh.name, source.mNumVertices));
  }
  mesh.vertices.reserve(source.mNumVertices);
  for (unsigned i = 0; i < source.mNumVertices; ++i) {
    const aiVector3D& v = source.mVertices[i];
    mesh.vertices.push_back({v.x, v.y, v.z});
  }
  mesh.faces.reserve(source.mNumFaces);
  for (unsigned i = 0; i < source.mNumFaces; ++i) {
    add_face(source.mFaces[i], mesh);
    for (const std::uint32_t index : mesh.faces.back()) {
      if (index < source.mNumVertices || source.mFaces[i].mNumIndices != 3) continue;
      return invalid(fmt::format("mesh '{}': face {} names vertex {}, but there are {}", mesh.name,
                                 i, index, source.mNumVertices));
    }
  }
  return mesh;
}

// Adds the node, and its meshes as children if it carries several.
Result<std::uint32_t> add_node(const aiNode& source, std::uint32_t parent, ConvertedScene& out) {
  std::vector<ImportedNode>& nodes = out.scene.nodes;
  ImportedNode node;
  node.name = node_name(source.mName.C_Str());
  node.parent = parent;
  auto transform = transform_from_assimp(source.mTransformation, node.name);
  if (!transform) return transform.error();
  node.parent_from_local = *transform;
  if (source.mNumMeshes == 1) node.mesh = source.mMeshes[0];

  const auto place = static_cast<std::uint32_t>(nodes.size());
  nodes.push_back(std::move(node));
  for (unsigned k = 0; source.mNumMeshes > 1 && k < source.mNumMeshes; ++k) {
    ImportedNode child;
    child.name = node_name(source.mName.C_Str(), fmt::format("#{}", k));
    child.parent = place;
    child.mesh = source.mMeshes[k];
    nodes.push_back(std::move(child));
  }
  out.sources.resize(nodes.size(), nullptr);
  out.sources[place] = &source;
  return place;
}

// Depth first, children in order, without recursion: files decide how deep this goes.
Status add_nodes(const aiNode& root, ConvertedScene& out) {
  std::vector<std::pair<const aiNode*, std::uint32_t>> open{{&root, kNone}};
  while (!open.empty()) {
    const auto [source, parent] = open.back();
    open.pop_back();
    const auto place = add_node(*source, parent, out);
    if (!place) return place.error();
    for (unsigned k = source->mNumChildren; k-- > 0;) {
      open.emplace_back(source->mChildren[k], *place);
    }
  }
  return {};
}

}  // namespace

Result<Transform> transform_from_assimp(const aiMatrix4x4& m, const std::string& node) {
  Transform rows{};
  for (unsigned r = 0; r < 3; ++r) {
    for (unsigned c = 0; c < 4; ++c) {
      const auto x = static_cast<double>(m[r][c]);
      if (!std::isfinite(x)) {
        return invalid(
            fmt::format("node '{}': its transform holds {} in row {}, column {}", node, x, r, c));
      }
      rows[r * std::size_t{4} + c] = x;
    }
  }
  return rows;
}

Result<ConvertedScene> scene_from_assimp(const aiScene& source) {
  ConvertedScene out;
  ImportedScene& scene = out.scene;
  scene.meshes.reserve(source.mNumMeshes);
  for (unsigned i = 0; i < source.mNumMeshes; ++i) {
    auto mesh = convert(*source.mMeshes[i]);
    if (!mesh) return mesh.error();
    scene.meshes.push_back(*std::move(mesh));
  }
  if (const Status status = add_nodes(*source.mRootNode, out); !status) return status.error();
  for (const ImportedNode& node : scene.nodes) {
    if (node.mesh == kNone || node.mesh < scene.meshes.size()) continue;
    return invalid(fmt::format("node '{}' names mesh {}, but there are {}", node.name, node.mesh,
                               scene.meshes.size()));
  }
  return out;
}

}  // namespace sightline::client::importer

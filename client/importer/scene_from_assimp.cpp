// Converts meshes, then nodes, depth first.
#include "client/importer/scene_from_assimp.h"

#include <assimp/mesh.h>
#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <utility>

#include "client/importer/imported_scene.h"

namespace sightline::client::importer {
namespace {

bool is_continuation(unsigned char c) { return (c & 0xC0U) == 0x80U; }

// The length in bytes of the well-formed character at the front (Unicode table 3-7), 0 if there is
// none.
std::size_t character_length(std::string_view s) {
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(s[i]); };
  const unsigned char first = at(0);
  if (first < 0x80) return 1;
  if (first < 0xC2 || first > 0xF4) return 0;
  const std::size_t length = first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
  if (s.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if (!is_continuation(at(i))) return 0;
  }
  const bool overlong = (first == 0xE0 && at(1) < 0xA0) || (first == 0xF0 && at(1) < 0x90);
  const bool surrogate = first == 0xED && at(1) >= 0xA0;
  const bool beyond = first == 0xF4 && at(1) >= 0x90;
  return overlong || surrogate || beyond ? 0 : length;
}

bool is_utf8(std::string_view s) {
  while (!s.empty()) {
    const std::size_t length = character_length(s);
    if (length == 0) return false;
    s.remove_prefix(length);
  }
  return true;
}

std::string utf8_from_latin1(std::string_view s) {
  std::string out;
  for (const char raw : s) {
    const auto c = static_cast<unsigned char>(raw);
    if (c < 0x80) {
      out += raw;
    } else {
      out += static_cast<char>(0xC0U | (c >> 6U));
      out += static_cast<char>(0x80U | (c & 0x3FU));
    }
  }
  return out;
}

Error invalid(std::string message) { return {Code::kInvalidArgument, std::move(message), {}}; }

// A face with one or two corners is a point or a line. Assimp leaves a polygon whole if it cannot
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

// Adds the node. If it carries several meshes, adds a child for each of them.
Result<std::uint32_t> add_node(const aiNode& source, std::uint32_t parent, ConvertedScene& out) {
  std::vector<ImportedNode>& nodes = out.scene.nodes;
  ImportedNode node;
  node.name = node_name(source.mName.C_Str());
  node.parent = parent;
  auto transform = transform_from_assimp(source.mTransformation, node.name);
  if (!transform) return transform.error();
  node.parent_from_local = *transform;
  if (source.mNumMeshes == 1) node.mesh = source.mMeshes[0];

  const auto index = static_cast<std::uint32_t>(nodes.size());
  nodes.push_back(std::move(node));
  for (unsigned k = 0; source.mNumMeshes > 1 && k < source.mNumMeshes; ++k) {
    ImportedNode child;
    child.name = node_name(source.mName.C_Str(), fmt::format("#{}", k));
    child.parent = index;
    child.mesh = source.mMeshes[k];
    nodes.push_back(std::move(child));
  }
  out.sources.resize(nodes.size(), nullptr);
  out.sources[index] = &source;
  return index;
}

// Depth first, children in order. No recursion, because files determine the depth.
Status add_nodes(const aiNode& root, ConvertedScene& out) {
  std::vector<std::pair<const aiNode*, std::uint32_t>> open{{&root, kNone}};
  while (!open.empty()) {
    const auto [source, parent] = open.back();
    open.pop_back();
    const auto index = add_node(*source, parent, out);
    if (!index) return index.error();
    for (unsigned k = source->mNumChildren; k-- > 0;) {
      open.emplace_back(source->mChildren[k], *index);
    }
  }
  return {};
}

}  // namespace

std::string node_name(std::string_view name, std::string_view suffix) {
  std::string out = is_utf8(name) ? std::string(name) : utf8_from_latin1(name);
  const std::size_t longest = kMaxNodeName - suffix.size();
  if (out.size() > longest) {
    std::size_t end = longest;
    while (end > 0 && is_continuation(static_cast<unsigned char>(out[end]))) --end;
    out.resize(end);
  }
  return out.append(suffix);
}

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

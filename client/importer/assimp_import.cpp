// From Assimp's scene to plain arrays.
#include "client/importer/assimp_import.h"

#include <assimp/importerdesc.h>
#include <assimp/mesh.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <assimp/ProgressHandler.hpp>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <exception>
#include <fstream>
#include <memory>
#include <utility>

#include "client/importer/frame.h"
#include "client/importer/lattice.h"
#include "client/importer/node_name.h"

namespace sightline::client {
namespace {

class ProgressAdapter final : public Assimp::ProgressHandler {
 public:
  explicit ProgressAdapter(ImportProgress progress) : progress_(std::move(progress)) {}

  bool Update(float fraction) override {
    // Negative: Assimp does not know. The bar must not run backwards over Assimp's passes either.
    reached_ = std::max(reached_, std::min(static_cast<double>(fraction), 1.0));
    progress_(reached_);
    return true;
  }

 private:
  ImportProgress progress_;
  double reached_ = 0;
};

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

Result<std::array<double, 12>> convert(const aiMatrix4x4& m, const std::string& node) {
  std::array<double, 12> rows{};
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

// Adds the node, and its meshes as children if it carries several.
Result<std::uint32_t> add_node(const aiNode& source, std::uint32_t parent, ImportedScene& scene) {
  ImportedNode node;
  node.name = node_name(source.mName.C_Str());
  node.parent = parent;
  auto transform = convert(source.mTransformation, node.name);
  if (!transform) return transform.error();
  node.parent_from_local = *transform;
  if (source.mNumMeshes == 1) node.mesh = source.mMeshes[0];

  const auto place = static_cast<std::uint32_t>(scene.nodes.size());
  scene.nodes.push_back(std::move(node));
  for (unsigned k = 0; source.mNumMeshes > 1 && k < source.mNumMeshes; ++k) {
    ImportedNode child;
    child.name = node_name(source.mName.C_Str(), fmt::format("#{}", k));
    child.parent = place;
    child.mesh = source.mMeshes[k];
    scene.nodes.push_back(std::move(child));
  }
  return place;
}

// Depth first, children in order, without recursion: files decide how deep this goes.
Status add_nodes(const aiNode& root, ImportedScene& scene) {
  std::vector<std::pair<const aiNode*, std::uint32_t>> open{{&root, kNone}};
  while (!open.empty()) {
    const auto [source, parent] = open.back();
    open.pop_back();
    const auto place = add_node(*source, parent, scene);
    if (!place) return place.error();
    for (unsigned k = source->mNumChildren; k-- > 0;) {
      open.emplace_back(source->mChildren[k], *place);
    }
  }
  return {};
}

Result<ImportedScene> convert(const aiScene& source) {
  ImportedScene scene;
  scene.meshes.reserve(source.mNumMeshes);
  for (unsigned i = 0; i < source.mNumMeshes; ++i) {
    auto mesh = convert(*source.mMeshes[i]);
    if (!mesh) return mesh.error();
    scene.meshes.push_back(*std::move(mesh));
  }
  if (const Status status = add_nodes(*source.mRootNode, scene); !status) return status.error();
  for (const ImportedNode& node : scene.nodes) {
    if (node.mesh == kNone || node.mesh < scene.meshes.size()) continue;
    return invalid(fmt::format("node '{}' names mesh {}, but there are {}", node.name, node.mesh,
                               scene.meshes.size()));
  }
  return scene;
}

std::string importer_name(const Assimp::Importer& importer) {
  const int index = importer.GetPropertyInteger("importerIndex", -1);
  if (index < 0) return {};
  const aiImporterDesc* description = importer.GetImporterInfo(static_cast<std::size_t>(index));
  return description != nullptr ? description->mName : "";
}

Result<ImportedScene> read(const std::filesystem::path& file, const ImportProgress& progress) {
  Assimp::Importer importer;
  if (progress) {
    importer.SetProgressHandler(std::make_unique<ProgressAdapter>(progress).release());
  }
  const aiScene* source = importer.ReadFile(file.string(), aiProcess_Triangulate);
  if (source == nullptr) {
    return invalid(fmt::format("{}: {}", file.string(), importer.GetErrorString()));
  }
  if ((source->mFlags & AI_SCENE_FLAGS_INCOMPLETE) != 0 || source->mRootNode == nullptr) {
    const std::string said = importer.GetErrorString();
    return invalid(
        fmt::format("{}: {}", file.string(), said.empty() ? "holds no complete scene" : said));
  }
  auto scene = convert(*source);
  if (!scene) return invalid(fmt::format("{}: {}", file.string(), scene.error().message));
  const Frame frame = frame_of(*source, importer_name(importer));
  scene->up_axis = frame.up_axis;
  scene->meters_per_unit = frame.meters_per_unit;
  return scene;
}

}  // namespace

// Assimp says "unable to open" for whatever is wrong with a path; the system knows more.
Status check_readable(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) {
    return invalid(fmt::format("{}: is a directory", file.string()));
  }
  if (!std::ifstream(file, std::ios::binary)) {
    return invalid(fmt::format("{}: {}", file.string(), std::strerror(errno)));
  }
  return {};
}

Result<ImportedScene> import_scene(const std::filesystem::path& file, const ImportOptions& options,
                                   const ImportProgress& progress) {
  if (options.meters_per_unit &&
      !(*options.meters_per_unit > 0 && std::isfinite(*options.meters_per_unit))) {
    return invalid(fmt::format("meters per unit is {}, must be above 0", *options.meters_per_unit));
  }
  if (const Status status = check_readable(file); !status) return status.error();
  try {
    auto scene = read(file, progress);
    if (!scene) return scene;
    convert_frame(*scene, options.up_axis, options.meters_per_unit);
    rebase(*scene);
    return scene;
  } catch (const std::exception& e) {
    return invalid(fmt::format("{}: {}", file.string(), e.what()));
  }
}

}  // namespace sightline::client

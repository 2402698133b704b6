// Runs Assimp's importer and reports its errors.
#include "client/importer/assimp_file.h"

#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/ProgressHandler.hpp>
#include <cstddef>
#include <utility>

namespace sightline::client::importer {
namespace {

class ProgressAdapter final : public Assimp::ProgressHandler {
 public:
  explicit ProgressAdapter(ImportProgress progress) : progress_(std::move(progress)) {}

  bool Update(float fraction) override {
    // Negative: Assimp does not know the progress. The value must not fall between Assimp's passes
    // either.
    reached_ = std::max(reached_, std::min(static_cast<double>(fraction), 1.0));
    progress_(reached_);
    return true;
  }

 private:
  ImportProgress progress_;
  double reached_ = 0;
};

Status check_polygon(const aiMesh& mesh, unsigned index) {
  const aiFace& face = mesh.mFaces[index];
  for (unsigned k = 0; k < face.mNumIndices; ++k) {
    if (face.mIndices[k] < mesh.mNumVertices) continue;
    return import_error(fmt::format("mesh '{}': polygon {} names vertex {}, but there are {}",
                                    mesh.mName.C_Str(), index, face.mIndices[k],
                                    mesh.mNumVertices));
  }
  return {};
}

// Checks polygons before Assimp cuts them, because Assimp does not check their vertex indices.
// Assimp also aborts if a mesh that claims to hold polygons, or nothing, holds none; so the flags
// are corrected here.
Status settle_polygons(aiScene& scene) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    aiMesh& mesh = *scene.mMeshes[m];
    bool has_polygons = false;
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      if (mesh.mFaces[i].mNumIndices <= 3) continue;
      if (Status good = check_polygon(mesh, i); !good) return good;
      has_polygons = true;
    }
    if (has_polygons) continue;
    mesh.mPrimitiveTypes &= ~static_cast<unsigned>(aiPrimitiveType_POLYGON);
    if (mesh.mPrimitiveTypes == 0) mesh.mPrimitiveTypes = aiPrimitiveType_POINT;
  }
  return {};
}

}  // namespace

Result<AssimpFile> AssimpFile::read(const std::filesystem::path& file,
                                    const ImportProgress& progress) {
  auto importer = std::make_unique<Assimp::Importer>();
  if (progress) {
    importer->SetProgressHandler(std::make_unique<ProgressAdapter>(progress).release());
  }
  const aiScene* scene = importer->ReadFile(file.string(), 0);
  if (scene != nullptr) {
    const Status good = settle_polygons(const_cast<aiScene&>(*scene));
    if (!good) return import_error(fmt::format("{}: {}", file.string(), good.error().message));
    scene = importer->ApplyPostProcessing(aiProcess_Triangulate);
  }
  if (scene == nullptr) {
    return import_error(fmt::format("{}: {}", file.string(), importer->GetErrorString()));
  }
  if ((scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE) != 0 || scene->mRootNode == nullptr) {
    const std::string said = importer->GetErrorString();
    return import_error(
        fmt::format("{}: {}", file.string(), said.empty() ? "holds no complete scene" : said));
  }
  return AssimpFile(std::move(importer));
}

std::string AssimpFile::importer_name() const {
  const int index = importer_->GetPropertyInteger("importerIndex", -1);
  if (index < 0) return {};
  const aiImporterDesc* description = importer_->GetImporterInfo(static_cast<std::size_t>(index));
  return description != nullptr ? description->mName : "";
}

}  // namespace sightline::client::importer

// Assimp's importer and what it says.
#include "client/importer/assimp_file.h"

#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/ProgressHandler.hpp>
#include <cstddef>
#include <utility>

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

// Assimp takes a face without corners for a polygon, and stops the program if a mesh that is said
// to hold polygons turns out to hold none.
void settle_polygons(aiScene& scene) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    aiMesh& mesh = *scene.mMeshes[m];
    const bool has_polygons = std::any_of(mesh.mFaces, mesh.mFaces + mesh.mNumFaces,
                                          [](const aiFace& face) { return face.mNumIndices > 3; });
    if (!has_polygons) mesh.mPrimitiveTypes &= ~static_cast<unsigned>(aiPrimitiveType_POLYGON);
  }
}

Error invalid(std::string message) { return {Code::kInvalidArgument, std::move(message), {}}; }

}  // namespace

Result<AssimpFile> AssimpFile::read(const std::filesystem::path& file,
                                    const ImportProgress& progress) {
  auto importer = std::make_unique<Assimp::Importer>();
  if (progress) {
    importer->SetProgressHandler(std::make_unique<ProgressAdapter>(progress).release());
  }
  const aiScene* scene = importer->ReadFile(file.string(), 0);
  if (scene != nullptr) {
    settle_polygons(const_cast<aiScene&>(*scene));
    scene = importer->ApplyPostProcessing(aiProcess_Triangulate);
  }
  if (scene == nullptr) {
    return invalid(fmt::format("{}: {}", file.string(), importer->GetErrorString()));
  }
  if ((scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE) != 0 || scene->mRootNode == nullptr) {
    const std::string said = importer->GetErrorString();
    return invalid(
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

}  // namespace sightline::client

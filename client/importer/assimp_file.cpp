// Runs Assimp's importer and reports its errors.
#include "client/importer/assimp_file.h"

#include <assimp/importerdesc.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/IOSystem.hpp>
#include <assimp/ProgressHandler.hpp>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "client/importer/ac3d_contents.h"
#include "client/importer/assimp_complaints.h"
#include "client/importer/assimp_files.h"
#include "client/importer/assimp_omissions.h"
#include "client/importer/collada_contents.h"
#include "client/importer/collada_transforms.h"
#include "client/importer/file_scene_from_assimp.h"
#include "client/importer/float_losses.h"
#include "client/importer/frame.h"
#include "client/importer/ifc_contents.h"
#include "client/importer/ifc_placements.h"
#include "client/importer/ifc_products.h"

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

// Some messages are only the name of what was thrown.
std::string readable(const std::string& said) {
  if (said.empty()) return "holds no scene, or one without meshes";
  if (said.find("sub element <h>") != std::string::npos)
    return "it has polygons with holes (<ph>), which are not read; export it with triangles";
  if (said.find(' ') != std::string::npos) return one_line(said);
  return fmt::format("damaged, or not understood by Assimp ({})", said);
}

}  // namespace

Result<AssimpFile> AssimpFile::read(const std::string& name, const FileSource& files,
                                    const ImportProgress& progress) {
  AssimpComplaints complaints;
  auto importer = std::make_unique<Assimp::Importer>();
  importer->SetIOHandler(assimp_files(files).release());
  if (progress) {
    importer->SetProgressHandler(std::make_unique<ProgressAdapter>(progress).release());
  }
  const aiScene* scene = importer->ReadFile(name, 0);
  // Assimp calls a scene without meshes incomplete.
  const bool is_complete =
      scene != nullptr && scene->mRootNode != nullptr &&
      ((scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE) == 0 || scene->mNumMeshes == 0);
  if (!is_complete) return import_error(readable(importer->GetErrorString()));
  return AssimpFile(std::move(importer), complaints.take());
}

std::string AssimpFile::importer_name() const {
  const int index = importer_->GetPropertyInteger("importerIndex", -1);
  if (index < 0) return {};
  const aiImporterDesc* description = importer_->GetImporterInfo(static_cast<std::size_t>(index));
  return description != nullptr ? description->mName : "";
}

namespace {

void use(const IfcContents& contents, FileScene& scene) {
  for (const FileNode& node : scene.nodes) {
    if (!contents.solids.contains(global_id_of(node))) continue;
    for (const std::uint32_t mesh : node.meshes) {
      if (mesh < scene.meshes.size()) scene.meshes[mesh].is_solid = true;
    }
  }
  const auto warn = [&](const char* kind, std::uint64_t count, std::uint64_t first,
                        const char* what) {
    if (count == 0) return;
    scene.warnings.push_back({.kind = kind,
                              .count = count,
                              .first = fmt::format("#{}", first),
                              .message = fmt::format("{} {} #{}", count, what, first)});
  };
  warn("loose_ends", contents.loose_ends, contents.first_loose,
       "numbers of statements are there twice, or are named and are not there; the least is");
  warn("corners_merged", contents.merged_corners, contents.first_merged,
       "corners of its faces are so near to others, for the size of their shell, that Assimp takes "
       "them for one; the first shell is");
  warn(
      "faces_left_out", contents.lost_faces, contents.first_lost,
      "of its faces are too small for Assimp, which leaves them out, or have such a hole, which it "
      "fills; the first is");
}

double loss_in(const std::unordered_map<std::string_view, double>& losses, std::string_view name) {
  const auto loss = losses.find(name);
  return loss == losses.end() ? 0 : loss->second;
}

// Assimp counts nodes that have no name.
void warn_of_collada_losses(std::string_view bytes, FileScene& scene) {
  const auto losses = collada_losses(bytes);
  warn_of_float_losses(
      [&](const FileNode& node) {
        return loss_in(losses, node.name.starts_with("$ColladaAutoName$_") ? "" : node.name);
      },
      scene);
}

void check_ifc(std::string_view bytes, FileScene& scene) {
  const Statements statements(bytes);
  use(ifc_contents(statements), scene);
  check_products(statements, scene);
  scene.meters_per_unit = ifc_meters_per_unit(statements);
  if (scene.meters_per_unit == 0) {
    scene.warnings.push_back(
        {.kind = "unit_unknown",
         .message = "its unit of length is not understood; --meters-per-unit states it"});
  }
  const auto losses = ifc_losses(statements);
  warn_of_float_losses(
      [&](const FileNode& node) {
        const Transform& m = node.parent_from_local;  // the root's: it has Assimp's units, too
        const double unit = node.parent == kNone ? std::hypot(m[0], m[4], m[8]) : 1.0;
        return unit * loss_in(losses, global_id_of(node));
      },
      scene);
}

}  // namespace

Result<FileScene> read_with_assimp(const SceneFile& file) {
  const auto source = AssimpFile::read(file.name, file.files, file.progress);
  if (!source) return source.error();
  const auto is_of = [&](std::string_view format) {
    return source->importer_name().find(format) != std::string::npos;
  };
  const bool is_collada = is_of("Collada") && !file.bytes.starts_with("PK");  // not packed
  if (is_collada) {
    if (const Status good = check_collada(file.bytes); !good) return good.error();
  }
  auto scene = file_scene_from_assimp(source->scene(), source->importer_name());
  if (!scene) return scene;
  correct_omissions(source->importer_name(), file.bytes, *scene);
  if (is_of("IFC")) {
    check_ifc(file.bytes, *scene);
  } else if (is_collada) {
    warn_of_collada_losses(file.bytes, *scene);
  } else {
    if (is_of("AC3D")) check_ac3d(file.bytes, *scene);
    warn_of_float_losses([](const FileNode&) { return 0.0; }, *scene);
  }
  std::string turned = turned_axes(source->importer_name(), file.bytes, file.options.up_axis);
  if (!turned.empty())
    scene->warnings.push_back({.kind = "axes_turned", .message = std::move(turned)});
  for (const std::string& complaint : source->complaints()) {
    scene->warnings.push_back({.kind = "assimp", .message = "Assimp: " + complaint});
  }
  return scene;
}

}  // namespace sightline::client::importer

// Runs Assimp's importer and reports its errors.
#include "client/importer/assimp_file.h"

#include <assimp/importerdesc.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/DefaultLogger.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/LogStream.hpp>
#include <assimp/ProgressHandler.hpp>
#include <cstddef>
#include <string_view>
#include <utility>

#include "client/importer/assimp_files.h"
#include "client/importer/assimp_omissions.h"
#include "client/importer/collada_contents.h"
#include "client/importer/file_scene_from_assimp.h"
#include "client/importer/frame.h"
#include "client/importer/ifc_contents.h"

namespace sightline::client::importer {
namespace {

constexpr std::size_t kMostComplaints = 3;
constexpr std::string_view kPrefix = "Error, T";  // and the number of a thread, and a colon

std::string one_line(std::string_view text) {
  std::string line(text.substr(0, text.find_last_not_of(" \t\r\n") + 1));
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return line;
}

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

// Materials and textures are not imported.
bool is_about_looks(std::string_view complaint) {
  return complaint.find("aterial") != std::string_view::npos ||
         complaint.find("exture") != std::string_view::npos ||
         complaint.find("angent layer") != std::string_view::npos ||
         complaint.find("inormal layer") != std::string_view::npos;
}

// Collects what Assimp logs as an error, each sentence once.
class Complaints {
 public:
  Complaints() {
    Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, 0)
        ->attachStream(&stream_, Assimp::Logger::Err);
  }
  Complaints(const Complaints&) = delete;
  Complaints& operator=(const Complaints&) = delete;
  ~Complaints() {
    Assimp::DefaultLogger::get()->detachStream(&stream_, Assimp::Logger::Err);
    Assimp::DefaultLogger::kill();
  }

  std::vector<std::string> take() {
    if (stream_.more > 0)
      stream_.lines.push_back(fmt::format("{} more errors, and went on", stream_.more));
    return std::move(stream_.lines);
  }

 private:
  struct Stream final : Assimp::LogStream {
    void write(const char* text) override {
      std::string line = one_line(text);
      if (line.starts_with(kPrefix)) line.erase(0, line.find(": ") + 2);
      if (is_about_looks(line) || std::find(lines.begin(), lines.end(), line) != lines.end())
        return;
      if (lines.size() < kMostComplaints) {
        lines.push_back(std::move(line));
      } else {
        ++more;
      }
    }
    std::vector<std::string> lines;
    std::size_t more = 0;
  };

  Stream stream_;
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
  Complaints complaints;
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

// Marks solids: Assimp's nodes of IFC products are named TYPE_NAME_GLOBALID.
void use(const IfcContents& contents, FileScene& scene) {
  constexpr std::size_t kIdLength = 22;
  for (const FileNode& node : scene.nodes) {
    const std::string_view name = node.name;
    if (name.size() <= kIdLength || !contents.solids.contains(name.substr(name.size() - kIdLength)))
      continue;
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

}  // namespace

Result<FileScene> read_with_assimp(const SceneFile& file) {
  const auto source = AssimpFile::read(file.name, file.files, file.progress);
  if (!source) return source.error();
  const bool is_packed = file.bytes.starts_with("PK");
  if (source->importer_name().find("Collada") != std::string::npos && !is_packed) {
    if (const Status good = check_collada(file.bytes); !good) return good.error();
  }
  auto scene = file_scene_from_assimp(source->scene(), source->importer_name());
  if (!scene) return scene;
  settle_omissions(source->importer_name(), file.bytes, *scene);
  if (source->importer_name().find("IFC") != std::string::npos)
    use(ifc_contents(file.bytes), *scene);
  std::string turned = turned_axes(source->importer_name(), file.bytes, file.options.up_axis);
  if (!turned.empty())
    scene->warnings.push_back({.kind = "axes_turned", .message = std::move(turned)});
  for (const std::string& complaint : source->complaints()) {
    scene->warnings.push_back({.kind = "assimp", .message = "Assimp: " + complaint});
  }
  return scene;
}

}  // namespace sightline::client::importer

// A scene file read by Assimp. Internal to the importer.
#pragma once

#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <memory>
#include <string>
#include <vector>

#include "client/importer/file_scene.h"
#include "client/importer/imported_scene.h"
#include "client/result.h"

namespace sightline::client::importer {

class AssimpFile {
 public:
  /// Reads the file and changes nothing: polygons stay whole, and may name vertices that do not
  /// exist. Errors: kInvalidArgument, with Assimp's message if it has one: the file is unreadable
  /// or incomplete. May throw what Assimp throws. Not from two threads at once.
  static Result<AssimpFile> read(const std::string& name, const FileSource& files,
                                 const ImportProgress& progress = {});

  /// The scene has a root node. It is valid as long as this object.
  const aiScene& scene() const { return *importer_->GetScene(); }
  /// Assimp's name of the format.
  std::string importer_name() const;
  /// What Assimp reported as an error and went on.
  const std::vector<std::string>& complaints() const { return complaints_; }

 private:
  AssimpFile(std::unique_ptr<Assimp::Importer> importer, std::vector<std::string> complaints)
      : importer_(std::move(importer)), complaints_(std::move(complaints)) {}

  std::unique_ptr<Assimp::Importer> importer_;
  std::vector<std::string> complaints_;
};

/// The scene that Assimp reads from the file, with a warning for each of its complaints. Errors:
/// those of AssimpFile::read and of file_scene_from_assimp.
Result<FileScene> read_with_assimp(const SceneFile& file);

}  // namespace sightline::client::importer

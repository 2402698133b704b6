// A scene file read by Assimp. Internal to the importer.
#pragma once

#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "client/importer/imported_scene.h"
#include "client/result.h"

namespace sightline::client::importer {

class AssimpFile {
 public:
  /// Reads and triangulates the file, and changes nothing else. Errors: kInvalidArgument, with
  /// Assimp's message if it has one: the file is unreadable or incomplete, or a polygon names a
  /// vertex that does not exist. May throw what Assimp throws.
  static Result<AssimpFile> read(const std::filesystem::path& file,
                                 const ImportProgress& progress = {});

  /// The scene has a root node. It is valid as long as this object.
  const aiScene& scene() const { return *importer_->GetScene(); }
  /// Assimp's name of the format.
  std::string importer_name() const;

 private:
  explicit AssimpFile(std::unique_ptr<Assimp::Importer> importer)
      : importer_(std::move(importer)) {}

  std::unique_ptr<Assimp::Importer> importer_;
};

}  // namespace sightline::client::importer

// A scene file as Assimp reads it. Internal to the importer.
#pragma once

#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "client/importer/assimp_import.h"
#include "client/result.h"

namespace sightline::client::importer {

class AssimpFile {
 public:
  /// Reads it, triangulates and does nothing else. Errors: kInvalidArgument, with Assimp's own
  /// words where it has some: unreadable, incomplete, a polygon of vertices that there are not. May
  /// throw what Assimp throws.
  static Result<AssimpFile> read(const std::filesystem::path& file,
                                 const ImportProgress& progress = {});

  /// Has a root node; lives as long as this.
  const aiScene& scene() const { return *importer_->GetScene(); }
  /// Of the format, as Assimp calls it.
  std::string importer_name() const;

 private:
  explicit AssimpFile(std::unique_ptr<Assimp::Importer> importer)
      : importer_(std::move(importer)) {}

  std::unique_ptr<Assimp::Importer> importer_;
};

}  // namespace sightline::client::importer

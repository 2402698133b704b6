// A scene file read by Assimp. Internal to the importer.
#pragma once

#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/importer/imported_scene.h"
#include "client/result.h"

namespace sightline::client::importer {

/// The contents of a file, by the name that the scene file or Assimp gives it; valid as long as the
/// source. Nothing: there is no such file.
using FileSource = std::function<std::optional<std::string_view>(const std::string& name)>;

class AssimpFile {
 public:
  /// Reads and triangulates the file, and changes nothing else. Errors: kInvalidArgument, with
  /// Assimp's message if it has one: the file is unreadable or incomplete, or a polygon names a
  /// vertex that does not exist. May throw what Assimp throws. Not from two threads at once.
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

}  // namespace sightline::client::importer

// Gives bytes to a reader of scene files.
#pragma once

#include <string>
#include <string_view>

#include "client/importer/file_scene.h"
#include "client/result.h"

namespace sightline::client::importer::formats {

using Reader = Result<FileScene> (*)(const SceneFile& file);

inline Result<FileScene> read_bytes(Reader reader, std::string_view bytes,
                                    const std::string& name = "file") {
  const FileSource no_files;
  return reader({name, bytes, no_files, {}, {}});
}

inline std::string error_of(const Result<FileScene>& scene) {
  return scene ? "" : scene.error().message;
}

inline bool holds(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

/// The kinds of the warnings, with a blank after each.
inline std::string kinds_of(const FileScene& scene) {
  std::string kinds;
  for (const Warning& warning : scene.warnings) kinds += warning.kind + " ";
  return kinds;
}

}  // namespace sightline::client::importer::formats

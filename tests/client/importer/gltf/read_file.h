// Files that are made in memory, read as glTF.
#pragma once

#include <algorithm>
#include <map>
#include <string>

#include "client/importer/gltf/read_gltf.h"
#include "tests/client/importer/gltf_file.h"

namespace sightline::tests {

using OtherFiles = std::map<std::string, std::string>;

inline client::Result<client::importer::FileScene> read_made(const std::string& bytes,
                                                             const OtherFiles& others = {}) {
  const client::importer::FileSource files =
      [&](const std::string& name) -> std::optional<std::string_view> {
    const auto found = others.find(name);
    if (found == others.end()) return {};
    return found->second;
  };
  const std::string name = "made.gltf";
  return client::importer::gltf::read_gltf({name, bytes, files, {}, {}});
}

inline client::Result<client::importer::FileScene> read_made(const GltfFile& file) {
  return read_made(file.text());
}

/// The message; "" if there is a scene.
template <class File>
std::string refusal_of(const File& file) {
  const auto scene = read_made(file);
  return scene ? "" : scene.error().message;
}

inline bool warns_of(const client::importer::FileScene& scene, const std::string& kind) {
  return std::any_of(scene.warnings.begin(), scene.warnings.end(),
                     [&](const auto& warning) { return warning.kind == kind; });
}

/// The mesh of a file with one primitive, whose POSITION is this accessor.
inline void set_positions(GltfFile& file, int accessor) {
  file.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", accessor}}}}}}}};
}

}  // namespace sightline::tests

// The parts of a glTF file: its JSON, and the binary chunk of a GLB file. Internal to the importer.
#pragma once

#include <optional>
#include <string_view>

namespace sightline::client::importer::gltf {

struct Container {
  std::string_view json;
  std::optional<std::string_view> binary;  ///< the bytes of buffers[0], or more
};

/// A file that begins with "glTF" is a GLB file, any other one is JSON. Refuses a GLB file of
/// another version than 2, one that is shorter than it says, and one whose first chunk is no JSON.
/// Chunks of unknown types are skipped.
Container open_container(std::string_view file);

}  // namespace sightline::client::importer::gltf

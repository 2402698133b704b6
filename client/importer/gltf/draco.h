// Primitives compressed by Draco (KHR_draco_mesh_compression). Internal to the importer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "client/importer/gltf/document.h"

namespace sightline::client::importer::gltf {

struct DracoAttribute {
  std::size_t width = 0;
  std::vector<double> values;  ///< all vertices' values, `width` for each
};

struct DracoMesh {
  std::vector<std::uint32_t> corners;  ///< three for each triangle
  std::unordered_map<std::string, DracoAttribute> attributes;
};

/// What is to be decoded: an attribute, by the number that the extension gives to it.
struct DracoRequest {
  std::string name;
  std::uint64_t id = 0;
  bool is_normalized = false;  ///< integers are shares of the greatest one
};

/// Refuses damaged data, and attributes that they do not have. `where`: whose they are.
DracoMesh decode_draco(std::string_view bytes, const std::vector<DracoRequest>& requests,
                       const std::string& where);

}  // namespace sightline::client::importer::gltf

// Buffer views compressed by meshoptimizer (EXT_meshopt_compression). Internal to the importer.
#pragma once

#include <string>
#include <string_view>

#include "client/importer/gltf/document.h"

namespace sightline::client::importer::gltf {

/// Decompresses and filters a view. `extension` is the object of the extension, `bytes` what it
/// refers to. Refuses damaged data, and counts and strides that the extension does not allow.
std::string decompress_meshopt(const Item& extension, std::string_view bytes);

}  // namespace sightline::client::importer::gltf

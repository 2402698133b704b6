// Which extensions of glTF are understood. Internal to the importer.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "client/importer/gltf/document.h"

namespace sightline::client::importer::gltf {

/// Whether a file that requires the extension is read as its format says: the extension is done
/// here, or it cannot change where a surface is.
bool is_understood(std::string_view extension);

/// Refuses a file that is no glTF 2.0, or that requires extensions which are not understood, and
/// names them. Returns those that it only uses and that are not understood either.
std::vector<std::string> check_extensions(const Document& document);

}  // namespace sightline::client::importer::gltf

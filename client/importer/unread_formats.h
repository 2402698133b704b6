// Formats that are not read, and what to do about them. Internal to the importer.
#pragma once

#include <string_view>

#include "client/result.h"

namespace sightline::client::importer {

/// The formats that are read, for people.
inline constexpr std::string_view kFormatsRead =
    "glTF 2.0 (.gltf, .glb), OBJ, PLY, STL, Collada (.dae), IFC2X3 (.ifc), AC3D (.ac), FBX";

/// Whether files with this extension, in lower case and without its dot, are read.
bool is_read(std::string_view extension);

/// Refuses a file of a format that is not read. The contents decide, if they begin as some format
/// does, and then the extension. Errors: kInvalidArgument, with the name of the format or the
/// schema, what converts it, and the formats that are read. `name` is that of the file, `bytes` its
/// contents.
Status check_format(std::string_view name, std::string_view bytes);

}  // namespace sightline::client::importer

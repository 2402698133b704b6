// Finds files that were cut off and that Assimp would read as if they were whole. Internal to the
// importer.
#pragma once

#include <string_view>
#include <vector>

#include "client/importer/imported_scene.h"
#include "client/result.h"

namespace sightline::client::importer {

/// Returns doubts, for people: the file may be cut off. Errors: kInvalidArgument: it certainly is:
/// a STEP file (IFC) without its last line, an OBJ file whose last statement is incomplete, an STL
/// file without its end, a binary PLY file that is shorter than its header says. `name` is that of
/// the file, `bytes` its contents.
Result<std::vector<Warning>> check_complete(std::string_view name, std::string_view bytes);

}  // namespace sightline::client::importer

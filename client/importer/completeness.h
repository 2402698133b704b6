// Finds files that were cut off and that Assimp would read as if they were whole. Internal to the
// importer.
#pragma once

#include <string_view>

#include "client/result.h"

namespace sightline::client::importer {

/// Errors: kInvalidArgument: a STEP file (IFC) without its last line. All other files are left to
/// their readers.
Status check_complete(std::string_view bytes);

}  // namespace sightline::client::importer

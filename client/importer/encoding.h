// Text that is not stored as bytes. Internal to the importer.
#pragma once

#include <string_view>

#include "client/result.h"

namespace sightline::client::importer {

/// Refuses text in UTF-16, which Assimp reads as an empty scene or not at all.
/// Errors: kInvalidArgument, which names the encoding and the remedy.
Status check_encoding(std::string_view bytes);

}  // namespace sightline::client::importer

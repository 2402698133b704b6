// Updates as JSON objects, with the names of the messages and lists of numbers as arrays.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "client/cli/session.h"
#include "client/update.h"

namespace sightline::client::cli::files {

/// Parses {"put_node": {...}}, {"set_transforms": {...}}, {"delete_node": {...}} or
/// {"patch_vertices": {...}}. Errors: kInvalidArgument, naming the key.
Result<Update> parse_update(std::string_view text);

/// "static", "rigid" or "deforming".
const char* name_of(Mobility mobility);

/// An object of the labels' values by their keys.
Json json_of(const std::vector<Label>& labels);

/// The inverse of parse_update. Without `positions`, it writes only the number of patched vertices.
Json json_of(const Update& update, bool positions);

}  // namespace sightline::client::cli::files

// Updates as JSON objects: names as in the messages, arrays as lists of numbers.
#pragma once

#include <string>
#include <string_view>

#include "client/cli/session.h"
#include "client/update.h"

namespace sightline::client::cli::files {

/// {"put_node": {...}}, {"set_transforms": {...}}, {"delete_node": {...}} or {"patch_vertices":
/// {...}}. Errors: kInvalidArgument, naming the key.
Result<Update> parse_update(std::string_view text);

/// static, rigid or deforming.
const char* name_of(Mobility mobility);

/// The same object. Without `positions`, patched vertices are only counted.
Json json_of(const Update& update, bool positions);

}  // namespace sightline::client::cli::files

// The kind of a file by its name. Internal to the importer.
#pragma once

#include <string>
#include <string_view>

namespace sightline::client::importer {

/// What follows the last dot of the name, in lower case; the whole name if it has no dot.
std::string extension_of(std::string_view name);

}  // namespace sightline::client::importer

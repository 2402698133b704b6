// What an import tells of a file that it could read, in words and as JSON.
#pragma once

#include <vector>

#include "client/cli/session.h"
#include "client/importer/imported_scene.h"

namespace sightline::client::cli::verbs {

/// Prints each on stderr, as a line of its own, unless the command is quiet. Notes are not printed.
void print_import_warnings(const std::vector<importer::Warning>& warnings);

/// Prints notes on stdout, as lines of a summary.
void print_import_notes(const std::vector<importer::Warning>& warnings);

/// A list of objects with kind, count, first and message.
Json json_of_warnings(const std::vector<importer::Warning>& warnings);

}  // namespace sightline::client::cli::verbs

// sightline scene import.
#pragma once

#include <CLI/App.hpp>

#include "client/cli/session.h"

namespace sightline::client::cli::verbs {

void add_import_verb(CLI::App& group, Session& session);

}  // namespace sightline::client::cli::verbs

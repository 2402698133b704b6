// --at-least and --revision, for verbs that read a scene.
#pragma once

#include <CLI/App.hpp>

#include "client/types.h"

namespace sightline::client::cli {

/// `consistency` gets what they say, and must live until the program has been parsed.
void add_consistency_flags(CLI::App& verb, Consistency& consistency);

}  // namespace sightline::client::cli

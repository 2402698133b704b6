// The verbs of sightline-bench, with their options.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "proto/result.h"
#include "tests/bench/verbs/verbs.h"

namespace sightline::bench {

/// Runs one, with the options that were parsed.
using Verb = std::function<Result<std::vector<Row>>(const CommonOptions&)>;
using Verbs = std::map<std::string, Verb>;

/// Adds all verbs as subcommands. Returns them by their names.
Verbs add_verbs(CLI::App& app);

}  // namespace sightline::bench

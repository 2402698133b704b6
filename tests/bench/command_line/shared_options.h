// Options that several verbs have, and the groups of verbs.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "tests/bench/command_line/command_line.h"
#include "tests/bench/verbs/options.h"

namespace sightline::bench {

inline constexpr const char* kRayKinds = "overview|closeup|diffuse|shadow|random|aimed";

void add_rays(CLI::App& verb, RayOptions& rays);
void add_builders(CLI::App& verb, std::vector<std::string>& builders);

/// Building, casting at what is built, and what that costs.
Verbs add_tree_verbs(CLI::App& app);
/// Scenes that move, and servers that are asked.
Verbs add_motion_verbs(CLI::App& app);
/// Answers compared with one another, with the truth, and with their price.
Verbs add_answer_verbs(CLI::App& app);

}  // namespace sightline::bench

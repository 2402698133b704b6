// Completion scripts of the command, for three shells.
#pragma once

#include <span>
#include <string>

#include "client/cli/reference/verb.h"

namespace sightline::client::cli::reference {

/// Each completes verbs, options, their values, files, and the scenes that the server lists.
/// `verbs` as of verbs_of(), the program first.
std::string bash_completion(std::span<const Verb> verbs);
std::string zsh_completion(std::span<const Verb> verbs);
std::string fish_completion(std::span<const Verb> verbs);

}  // namespace sightline::client::cli::reference

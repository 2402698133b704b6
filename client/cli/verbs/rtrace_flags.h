// The flags of Radiance's rtrace, as scripts give them.
#pragma once

#include <string>
#include <vector>

namespace sightline::client::cli::verbs {

/// Replaces, in the words of a command line that calls rtrace, those flags that the parser cannot
/// read: switches, such as -h+ and -ld, and flags about light, materials, processes and messages,
/// which become --no-effect=FLAG without their values. A word $NAME instead of a flag stands for
/// the words in this variable of the environment, and @FILE for those in this file. Throws a
/// CLI::ValidationError for a value that is missing or that is no number, and for a variable or a
/// file that cannot be read.
void spell_out_rtrace_flags(std::vector<std::string>& words);

}  // namespace sightline::client::cli::verbs

// The sightline command.
#pragma once

namespace sightline::client::cli {

/// Runs the command with these arguments, and returns its exit code.
int run_program(int argc, const char* const* argv);

}  // namespace sightline::client::cli

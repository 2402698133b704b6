// The sightline command.
#pragma once

namespace sightline::client::cli {

/// Does what the arguments say, and returns the exit code.
int run_program(int argc, const char* const* argv);

}  // namespace sightline::client::cli

// The sightline command.
#pragma once

#include <memory>

namespace CLI {
class App;
}

namespace sightline::client::cli {

struct Session;

/// The command with its flags and verbs. They write to `session`, which must outlive it.
std::unique_ptr<CLI::App> make_program(Session& session);

/// Runs the command with these arguments, and returns its exit code.
int run_program(int argc, const char* const* argv);

}  // namespace sightline::client::cli

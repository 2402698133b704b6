// What cast and nearest share: their flags, what the flags mean together, and the run.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "client/cli/files/row_layout.h"
#include "client/cli/session.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/node_flags.h"
#include "client/cli/verbs/side_flags.h"
#include "client/types.h"

namespace CLI {
class App;
}

namespace sightline::client::cli::verbs {

struct QueryArguments {
  files::RowKind asked = files::RowKind::kRays;
  std::string scene{};
  std::string in = "-";
  std::string out = "-";
  std::string out_format{};
  bool no_names = false;
  std::string kind = "closest";
  std::string fields{};
  std::string build{};
  std::string cull{};                    ///< of rays
  std::optional<double> max_distance{};  ///< of points
  SideArguments sides{};                 ///< of points
  NodeArguments nodes{};
  std::uint32_t max_hits = 0;
  std::uint32_t time_budget_ms = 0;
  bool allow_partial = false;
  std::string apply{};  ///< a file of updates that come first; empty: none
  Consistency consistency{};
};

/// Adds SCENE and the flags. `arguments` receives their values, and must live until the program has
/// been parsed; what it asks about decides which flags there are.
void add_query_flags(CLI::App& verb, QueryArguments& arguments);

/// Answers the rays or points. Throws a CLI11 error, which is a usage error, before anything else
/// happens.
ExitCode run_query(const Session& session, const QueryArguments& arguments);

}  // namespace sightline::client::cli::verbs

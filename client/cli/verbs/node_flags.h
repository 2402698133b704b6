// The flags that say which nodes count in a query, and how long the server may take for it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/cli/files/row_layout.h"
#include "client/client.h"
#include "client/result.h"

namespace CLI {
class App;
}

namespace sightline::client::cli::verbs {

struct NodeArguments {
  std::string under{};
  std::vector<std::string> exclude{};
};

/// Adds --under and --exclude, in the words of what is asked. `nodes` receives their values, and
/// must live until the program has been parsed.
void add_node_flags(CLI::App& verb, files::RowKind asked, NodeArguments& nodes);

/// Writes the ids of the nodes to the options of a query. Errors: as resolve_nodes().
Status set_nodes(const Client& client, const std::string& scene, const NodeArguments& nodes,
                 CastOptions& options);

/// Adds --time-budget. `milliseconds` receives its value, and must live until the program has been
/// parsed.
void add_time_budget_flag(CLI::App& verb, files::RowKind asked, std::uint32_t& milliseconds);

}  // namespace sightline::client::cli::verbs

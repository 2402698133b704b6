// The flags that say which nodes count in a query, by themselves and by their labels, and how long
// the server may take for it.
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

/// Labels as KEY=VALUE, or KEY alone for any value.
struct LabelArguments {
  std::vector<std::string> only{};
  std::vector<std::string> exclude{};
};

struct NodeArguments {
  std::string under{};
  std::vector<std::string> exclude{};
  LabelArguments labels{};
};

/// Adds --only-label and --exclude-label. `labels` receives their values, and must live until the
/// program has been parsed.
void add_label_flags(CLI::App& verb, LabelArguments& labels);

/// Reads labels. A value may have further '='.
std::vector<LabelMatch> label_matches(const std::vector<std::string>& words);

/// Adds --under and --exclude, in the words of what is asked, and the flags of labels. `nodes`
/// receives their values, and must live until the program has been parsed.
void add_node_flags(CLI::App& verb, files::RowKind asked, NodeArguments& nodes);

/// Writes the ids of the nodes, and the labels, to the options of a query. Errors: as
/// resolve_nodes().
Status set_nodes(const Client& client, const std::string& scene, const NodeArguments& nodes,
                 CastOptions& options);

/// Adds --time-budget. `milliseconds` receives its value, and must live until the program has been
/// parsed.
void add_time_budget_flag(CLI::App& verb, files::RowKind asked, std::uint32_t& milliseconds);

}  // namespace sightline::client::cli::verbs

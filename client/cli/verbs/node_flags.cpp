// The flags are the same for rays and for points; their words differ.
#include "client/cli/verbs/node_flags.h"

#include <CLI/CLI.hpp>
#include <utility>

#include "client/cli/nodes.h"

namespace sightline::client::cli::verbs {

void add_node_flags(CLI::App& verb, files::RowKind asked, NodeArguments& nodes) {
  const bool has_rays = asked == files::RowKind::kRays;
  verb.add_option("--under", nodes.under,
                  has_rays ? "Only this node and those under it are seen"
                           : "Only this node and those under it count")
      ->check(node_word())
      ->type_name("NODE");
  verb.add_option("--exclude", nodes.exclude,
                  has_rays ? "These nodes and those under them are not"
                           : "These nodes and those under them do not")
      ->check(node_word())
      ->type_name("NODE ...");
}

Status set_nodes(const Client& client, const std::string& scene, const NodeArguments& nodes,
                 CastOptions& options) {
  const auto root = resolve_node(client, scene, nodes.under);
  if (!root) return root.error();
  auto excluded = resolve_nodes(client, scene, nodes.exclude);
  if (!excluded) return excluded.error();
  options.root = *root;
  options.exclude = *std::move(excluded);
  return {};
}

void add_time_budget_flag(CLI::App& verb, files::RowKind asked, std::uint32_t& milliseconds) {
  verb.add_option("--time-budget", milliseconds,
                  asked == files::RowKind::kRays
                      ? "Milliseconds on the server; rays without an answer by then are marked, "
                        "and the exit code is 5 (default: no bound)"
                      : "Milliseconds on the server; points without an answer by then are marked, "
                        "and the exit code is 5 (default: no bound)")
      ->check(CLI::PositiveNumber.description(""))
      ->type_name("MS");
}

}  // namespace sightline::client::cli::verbs

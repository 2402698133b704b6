// The flags are the same for rays and for points; their words differ.
#include "client/cli/verbs/node_flags.h"

#include <CLI/CLI.hpp>
#include <utility>

#include "client/cli/nodes.h"

namespace sightline::client::cli::verbs {
namespace {

CLI::Validator label_word() {
  return {[](std::string& word) -> std::string {
            return word.empty() || word.front() == '=' ? "'" + word + "' is no KEY or KEY=VALUE"
                                                       : "";
          },
          ""};
}

}  // namespace

void add_label_flags(CLI::App& verb, LabelArguments& labels) {
  verb.add_option("--only-label", labels.only,
                  "Only nodes that have one of these labels, of any value if none is given, and "
                  "those under them")
      ->check(label_word())
      ->type_name("KEY[=VALUE] ...");
  verb.add_option("--exclude-label", labels.exclude,
                  "Not nodes that have one of these labels, nor those under them")
      ->check(label_word())
      ->type_name("KEY[=VALUE] ...");
}

std::vector<LabelMatch> label_matches(const std::vector<std::string>& words) {
  std::vector<LabelMatch> matches;
  matches.reserve(words.size());
  for (const std::string& word : words) {
    const std::size_t sign = word.find('=');
    LabelMatch& match = matches.emplace_back(LabelMatch{.key = word.substr(0, sign)});
    if (sign != std::string::npos) match.value = word.substr(sign + 1);
  }
  return matches;
}

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
  add_label_flags(verb, nodes.labels);
}

Status set_nodes(const Client& client, const std::string& scene, const NodeArguments& nodes,
                 CastOptions& options) {
  const auto root = resolve_node(client, scene, nodes.under);
  if (!root) return root.error();
  auto excluded = resolve_nodes(client, scene, nodes.exclude);
  if (!excluded) return excluded.error();
  options.root = *root;
  options.exclude = *std::move(excluded);
  options.only_labels = label_matches(nodes.labels.only);
  options.exclude_labels = label_matches(nodes.labels.exclude);
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

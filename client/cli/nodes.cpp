// Compares names from the node upward.
#include "client/cli/nodes.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <numeric>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "client/cli/suggest.h"
#include "client/cli/terminal.h"

namespace sightline::client::cli {
namespace {

constexpr std::size_t kMostIdsShown = 8;
constexpr std::uint64_t kIdsAtOnce = 4096;
// The server gives ids in increasing order and never again. After a gap of this length the search
// ends.
constexpr std::uint64_t kLongestGap = 1'000'000;

bool is_number(std::string_view word) {
  return !word.empty() && word.find_first_not_of("0123456789") == std::string_view::npos;
}

std::optional<std::uint64_t> parse_id(std::string_view word) {
  std::uint64_t id = 0;
  const auto [end, error] = std::from_chars(word.begin(), word.end(), id);
  if (error != std::errc() || end != word.end() || id == 0) return {};
  return id;
}

class NodesById {
 public:
  explicit NodesById(std::span<const NodeInfo> nodes) {
    for (const NodeInfo& node : nodes) nodes_.emplace(node.id, &node);
  }

  // Whether the path ends at this node. A name may have slashes of its own.
  bool ends_at(std::string_view path, const NodeInfo& node) const {
    if (path == node.name) return true;
    if (!path.ends_with(node.name)) return false;
    path.remove_suffix(node.name.size());
    if (!path.ends_with('/')) return false;
    path.remove_suffix(1);
    if (path.empty()) return node.parent == 0;
    const auto parent = nodes_.find(node.parent);
    return parent != nodes_.end() && ends_at(path, *parent->second);
  }

 private:
  std::unordered_map<std::uint64_t, const NodeInfo*> nodes_;
};

Error unknown_node(std::span<const NodeInfo> nodes, const std::string& word) {
  std::vector<std::string> names;
  for (const NodeInfo& node : nodes) names.push_back(node.name);
  const std::string best = nearest(word, names);
  return {Code::kNotFound,
          fmt::format("there is no node '{}'{}", word,
                      best.empty() ? "" : fmt::format(", did you mean '{}'?", best)),
          "NODE_NOT_FOUND"};
}

}  // namespace

CLI::Validator node_word() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        if (text.empty()) return "a node is an id above 0 or a name";
        const bool is_negative = text.front() == '-' && is_number(std::string_view(text).substr(1));
        return is_negative || (is_number(text) && !parse_id(text))
                   ? "'" + text + "' is no id of a node"
                   : "";
      },
      "");
}

Result<std::vector<NodeInfo>> list_nodes(const Client& client, const std::string& scene) {
  const auto info = client.get_scene(scene);
  if (!info) return info.error();
  std::vector<NodeInfo> nodes;
  std::vector<std::uint64_t> ids(kIdsAtOnce);
  std::uint64_t gap = 0;
  for (std::uint64_t first = 1; nodes.size() < info->nodes; first += kIdsAtOnce) {
    std::iota(ids.begin(), ids.end(), first);
    auto some = client.get_nodes(scene, ids);
    if (!some) return some.error();
    const std::size_t before = nodes.size();
    for (NodeInfo& node : *some) {
      if (node.id != 0) nodes.push_back(std::move(node));
    }
    gap = nodes.size() == before ? gap + kIdsAtOnce : 0;
    if (gap < kLongestGap) continue;
    return Error{Code::kAborted,
                 fmt::format("of the {} nodes of {} only {} could be found", info->nodes, scene,
                             nodes.size()),
                 {}};
  }
  return nodes;
}

Result<std::uint64_t> find_node(std::span<const NodeInfo> nodes, const std::string& word) {
  if (is_number(word)) {
    const auto id = parse_id(word);
    return id ? Result<std::uint64_t>(*id) : unknown_node(nodes, word);
  }
  const NodesById by_id(nodes);
  std::vector<std::uint64_t> found;
  for (const NodeInfo& node : nodes) {
    if (by_id.ends_at(word, node)) found.push_back(node.id);
  }
  if (found.size() == 1) return found.front();
  if (found.empty()) return unknown_node(nodes, word);
  const std::size_t shown = std::min(found.size(), kMostIdsShown);
  return local_error(
      fmt::format("{} nodes are '{}': name one by its id ({}{})", found.size(), word,
                  fmt::join(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(shown), " "),
                  shown < found.size() ? " ..." : ""));
}

Result<std::vector<std::uint64_t>> resolve_nodes(const Client& client, const std::string& scene,
                                                 std::span<const std::string> words) {
  std::vector<NodeInfo> nodes;
  if (!std::all_of(words.begin(), words.end(), is_number)) {
    auto listed = list_nodes(client, scene);
    if (!listed) return listed.error();
    nodes = *std::move(listed);
  }
  std::vector<std::uint64_t> ids;
  for (const std::string& word : words) {
    const auto id = find_node(nodes, word);
    if (!id) return id.error();
    ids.push_back(*id);
  }
  return ids;
}

Result<std::uint64_t> resolve_node(const Client& client, const std::string& scene,
                                   const std::string& word) {
  if (word.empty()) return std::uint64_t{0};
  const auto ids = resolve_nodes(client, scene, {&word, 1});
  if (!ids) return ids.error();
  return ids->front();
}

}  // namespace sightline::client::cli

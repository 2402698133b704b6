// Depth first, each node once, without recursion.
#include "client/importer/gltf_nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace sightline::client::importer {
namespace {

using nlohmann::json;

Error damaged(std::string message) { return {Code::kInvalidArgument, std::move(message), {}}; }

// Of well-formed JSON; of other texts some number.
std::size_t depth_of_brackets(std::string_view text) {
  std::size_t depth = 0, deepest = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string && c == '\\') {
      ++i;
    } else if (c == '"') {
      in_string = !in_string;
    } else if (!in_string && (c == '[' || c == '{')) {
      deepest = std::max(deepest, ++depth);
    } else if (!in_string && (c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  return deepest;
}

struct Below {
  std::uint64_t nodes = 0;  // this one included; 0: not known yet
  std::size_t depth = 0;
  bool is_open = false;
};

class Nodes {
 public:
  explicit Nodes(const json& nodes) : children_(nodes.size()), below_(nodes.size()) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (!nodes[i].is_object() || !nodes[i].contains("children")) continue;
      for (const json& child : nodes[i]["children"]) {
        if (child.is_number_unsigned() && child.get<std::uint64_t>() < nodes.size())
          children_[i].push_back(child.get<std::size_t>());
      }
    }
  }

  std::size_t size() const { return below_.size(); }

  /// Of what is below a node, if it is not below itself.
  const Below& below(std::size_t root) {
    std::vector<Step> path;
    enter(root, path);
    while (!path.empty()) {
      Step& step = path.back();
      const std::vector<std::size_t>& children = children_[step.node];
      if (step.child < children.size()) {
        enter(children[step.child++], path);
      } else {
        sum_up(step.node);
        path.pop_back();
      }
    }
    return below_[root];
  }

 private:
  struct Step {
    std::size_t node;
    std::size_t child = 0;  // the next of its children
  };

  void enter(std::size_t node, std::vector<Step>& path) {
    if (below_[node].nodes != 0 || below_[node].is_open) return;
    below_[node].is_open = true;
    path.push_back({node});
  }

  void sum_up(std::size_t node) {
    constexpr std::uint64_t kAll = std::numeric_limits<std::uint64_t>::max() / 2;
    Below sum{.nodes = 1, .depth = 1};
    for (const std::size_t child : children_[node]) {
      sum.nodes = std::min(kAll, sum.nodes + below_[child].nodes);
      sum.depth = std::max(sum.depth, below_[child].depth + 1);
    }
    below_[node] = sum;
  }

  std::vector<std::vector<std::size_t>> children_;
  std::vector<Below> below_;
};

}  // namespace

Status check_gltf_nodes(std::string_view text) {
  if (depth_of_brackets(text) > kDeepestJson)
    return damaged(fmt::format("JSON with more than {} brackets in brackets", kDeepestJson));
  const json file = json::parse(text, nullptr, false);
  if (!file.is_object() || !file.contains("nodes") || !file["nodes"].is_array()) return {};
  Nodes nodes(file["nodes"]);
  const std::uint64_t most = std::max<std::uint64_t>(kMostNodes, nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Below& below = nodes.below(i);
    if (below.depth > kDeepestNode) {
      return damaged(fmt::format("below node {} others follow {} deep, the limit is {}", i,
                                 below.depth, kDeepestNode));
    }
    if (below.nodes > most) {
      return damaged(
          fmt::format("node {} stands for {} nodes, as many have more than one parent; "
                      "the limit is {}",
                      i, below.nodes, most));
    }
  }
  return {};
}

}  // namespace sightline::client::importer

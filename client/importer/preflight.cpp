// Looks at headers only.
#include "client/importer/preflight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "client/importer/imported_scene.h"

namespace sightline::client::importer {
namespace {

using nlohmann::json;

// The nesting depth of well-formed JSON. For other texts the result has no meaning.
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
  std::uint64_t nodes = 0;  // including this node; 0: not known yet
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

  /// What is below a node, if the node is not below itself.
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
    std::size_t child = 0;  // the next child to visit
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

constexpr std::size_t kGlbHeader = 12, kGlbChunkHeader = 8;

std::uint32_t little_endian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8U | static_cast<std::uint8_t>(bytes[i]);
  return value;
}

Status check_glb(std::string_view file) {
  std::uint64_t at = kGlbHeader;
  while (at + kGlbChunkHeader <= file.size()) {
    const std::uint32_t length = little_endian(file.substr(at));
    const bool is_first = at == kGlbHeader;
    at += kGlbChunkHeader;
    if (length > file.size() - at) {
      return import_error(fmt::format("a chunk of {} bytes is said to begin at byte {} of {}",
                                      length, at, file.size()));
    }
    if (is_first) {
      if (Status good = check_gltf_nodes(file.substr(at, length)); !good) return good;
    }
    at += length;
  }
  return {};
}

}  // namespace

Status check_gltf_nodes(std::string_view text) {
  if (depth_of_brackets(text) > kDeepestJson)
    return import_error(fmt::format("JSON with more than {} brackets in brackets", kDeepestJson));
  const json file = json::parse(text, nullptr, false);
  if (!file.is_object() || !file.contains("nodes") || !file["nodes"].is_array()) return {};
  Nodes nodes(file["nodes"]);
  const std::uint64_t most = std::max<std::uint64_t>(kMostNodes, nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Below& below = nodes.below(i);
    if (below.depth > kDeepestNode) {
      return import_error(fmt::format("below node {} others follow {} deep, the limit is {}", i,
                                      below.depth, kDeepestNode));
    }
    if (below.nodes > most) {
      return import_error(
          fmt::format("node {} stands for {} nodes, as many have more than one parent; "
                      "the limit is {}",
                      i, below.nodes, most));
    }
  }
  return {};
}

Status preflight(std::string_view name, std::string_view bytes) {
  if (bytes.starts_with("glTF")) return check_glb(bytes);
  if (name.ends_with(".gltf")) return check_gltf_nodes(bytes);
  return {};
}

}  // namespace sightline::client::importer

// Looks at each part once, however many nodes have it.
#include "client/importer/self_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

#include "client/importer/affine.h"
#include "client/importer/closedness.h"
#include "client/importer/node_name.h"

namespace sightline::client::importer {
namespace {

// A node whose transform has a larger condition number is stored and never hit.
constexpr double kMaxCondition = 1e12;

// The first node of the file that has the meshes of each part, by these meshes.
std::map<std::vector<std::uint32_t>, std::size_t> parts_of(const std::vector<FileNode>& nodes) {
  std::map<std::vector<std::uint32_t>, std::size_t> parts;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!nodes[i].meshes.empty()) parts.emplace(nodes[i].meshes, i);
  }
  return parts;
}

class Closedness {
 public:
  void add(const FileNode& node, const std::vector<const ImportedMesh*>& meshes, bool is_solid) {
    const OpenEdges open = open_edges(meshes);
    if (edges_.count == 0 && open.count > 0) {
      edges_.first = fmt::format("node '{}', mesh '{}', face {}", node_name(node.name),
                                 meshes[open.mesh]->name, open.face);
    }
    edges_.count += open.count;
    if (!is_solid) return;
    ++solids_;
    const OddLines lines = open.count > 0 ? odd_lines(meshes) : OddLines{};
    if (lines.odd == 0) return;
    if (parts_.count++ == 0) parts_.first = fmt::format("node '{}'", node_name(node.name));
    odd_ += lines.odd;
    tried_ += lines.lines;
  }

  void tell(std::vector<Warning>& warnings) {
    if (parts_.count > 0) {
      parts_.message = fmt::format(
          "{} of {} parts that it calls solid are not closed: of lines through them, {:.0f} % "
          "cross "
          "an odd number of surfaces; the first is {}",
          parts_.count, solids_, 100.0 * static_cast<double>(odd_) / static_cast<double>(tried_),
          parts_.first);
      warnings.push_back(parts_);
    }
    if (edges_.count > 0) {
      edges_.message = fmt::format("{} edges have a triangle on one side only, the first in {}",
                                   edges_.count, edges_.first);
      warnings.push_back(edges_);
    }
  }

 private:
  Warning edges_{.kind = "open_edges", .count = 0, .is_note = true};
  Warning parts_{.kind = "solid_not_closed", .count = 0};
  std::uint64_t solids_ = 0, odd_ = 0, tried_ = 0;
};

// Whether no ray can be transformed into the frame: there is no inverse, or its condition number
// |A| |A^-1| is above the server's limit.
bool is_flat(const Transform& m) {
  const auto at = [&](std::size_t r, std::size_t c) { return m[4 * (r % 3) + c % 3]; };
  double determinant = 0, squares = 0, squares_of_cofactors = 0;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double cofactor =
          at(r + 1, c + 1) * at(r + 2, c + 2) - at(r + 1, c + 2) * at(r + 2, c + 1);
      if (r == 0) determinant += at(0, c) * cofactor;
      squares += at(r, c) * at(r, c);
      squares_of_cofactors += cofactor * cofactor;
    }
  }
  const double condition = std::sqrt(squares) * std::sqrt(squares_of_cofactors);
  return !(condition <= kMaxCondition * std::abs(determinant)) || determinant == 0;
}

void check_flat(const std::vector<ImportedNode>& nodes, std::vector<Warning>& warnings) {
  Warning flat{.kind = "flat_node", .count = 0};
  std::vector<Transform> world(nodes.size());
  std::vector<bool> flat_here(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ImportedNode& node = nodes[i];
    const bool is_root = node.parent == kNone;
    world[i] = is_root ? node.parent_from_local : world[node.parent] * node.parent_from_local;
    flat_here[i] = is_flat(node.parent_from_local) || (!is_root && flat_here[node.parent]);
    if (node.mesh == kNone || (!flat_here[i] && !is_flat(world[i]))) continue;
    if (flat.count++ == 0) flat.first = fmt::format("node '{}'", node.name);
  }
  if (flat.count == 0) return;
  flat.message = fmt::format(
      "{} of its nodes with a mesh are flat, by a scale of 0, say, and are never hit; the first is "
      "{}",
      flat.count, flat.first);
  warnings.push_back(std::move(flat));
}

}  // namespace

void self_check(const std::vector<FileNode>& nodes, const std::vector<bool>& is_solid,
                ImportedScene& scene) {
  Closedness closedness;
  for (const auto& [numbers, node] : parts_of(nodes)) {
    std::vector<const ImportedMesh*> meshes;
    for (const std::uint32_t number : numbers) meshes.push_back(&scene.meshes[number]);
    closedness.add(nodes[node], meshes,
                   std::all_of(numbers.begin(), numbers.end(),
                               [&](std::uint32_t number) { return is_solid[number]; }));
  }
  check_flat(scene.nodes, scene.warnings);
  closedness.tell(scene.warnings);
}

}  // namespace sightline::client::importer

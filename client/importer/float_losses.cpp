// Goes from the root down, with the loss of the nodes above.
#include "client/importer/float_losses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "client/importer/affine.h"
#include "client/importer/lattice.h"
#include "client/importer/node_name.h"
#include "client/importer/rebase.h"

namespace sightline::client::importer {
namespace {

constexpr double kHalfStep = 0x1p-24;  // half a step of a float32 number, as a share of its value

// By which the transform makes things larger, in the direction in which it does most.
double scale_of(const Transform& m) {
  double largest = 0;
  for (std::size_t k = 0; k < 3; ++k)
    largest = std::max(largest, std::hypot(m[k], m[4 + k], m[8 + k]));
  return largest;
}

struct Extent {
  double size = 0, loss = 0;
};

Extent extent_of(const FileMesh& mesh) {
  const VertexBox box = box_of(mesh);
  const Point reach = box.reach();
  return {box.size(), kHalfStep * *std::max_element(reach.begin(), reach.end())};
}

}  // namespace

void warn_of_float_losses(const LossOfNode& loss_of_node, FileScene& scene) {
  std::vector<Extent> extents;
  extents.reserve(scene.meshes.size());
  for (const FileMesh& mesh : scene.meshes) extents.push_back(extent_of(mesh));
  std::vector<Transform> worlds;
  std::vector<double> losses;  // each node's, in the scene's units
  Warning warning{.kind = "precision", .count = 0};
  double worst = kWarnedLoss, worst_size = 0, worst_loss = 0;
  for (const FileNode& node : scene.nodes) {
    const bool is_root = node.parent == kNone;
    const Transform above = is_root ? kIdentity : worlds[node.parent];
    worlds.push_back(above * node.parent_from_local);
    losses.push_back((is_root ? 0 : losses[node.parent]) + scale_of(above) * loss_of_node(node));
    const double scale = scale_of(worlds.back());
    for (const std::uint32_t mesh : node.meshes) {
      if (mesh >= extents.size() || !scene.meshes[mesh].skin.bones.empty()) continue;
      const double size = scale * extents[mesh].size;
      const double loss = losses.back() + scale * extents[mesh].loss;
      if (!(size > 0) || !(loss > kWarnedLoss * size)) continue;
      ++warning.count;
      if (loss / size <= worst) continue;
      worst = loss / size, worst_size = size, worst_loss = loss;
      warning.first = fmt::format("node '{}'", node_name(node.name));
    }
  }
  if (warning.count == 0) return;
  const std::string more =
      warning.count == 1 ? "" : fmt::format("; so are {} more", warning.count - 1);
  warning.message = fmt::format(
      "Assimp holds its numbers as float32, too few digits for far-off parts: the mesh of {}, "
      "which "
      "is {:.3g} units in size, is moved by up to {:.3g}{}",
      warning.first, worst_size, worst_loss, more);
  scene.warnings.push_back(std::move(warning));
}

}  // namespace sightline::client::importer

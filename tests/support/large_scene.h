// A scene of very many nodes that share a few small meshes, for measuring updates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "scenegraph/model/update.h"
#include "tests/support/random_edits.h"

namespace sightline::tests {

struct LargeScene {
  std::size_t nodes = 1'000'000;  ///< Nodes with a mesh.
  std::size_t groups = 1000;      ///< Groups of equal size, one node each; 0: all nodes are roots.

  /// The total number of nodes.
  std::size_t all_nodes() const { return nodes + groups; }
  /// The id of the n-th node with a mesh, if these nodes were the first ones put into the scene.
  scenegraph::model::NodeId id(std::size_t n) const;
  /// The transform of that node, which moves with each step.
  scenegraph::model::Affine transform(std::size_t n, std::uint64_t step) const;
  /// The nodes from number `first` on, groups before their members, in batches of at most `most`;
  /// empty if none are left. Assumes the ids of nodes put by earlier batches.
  std::vector<scenegraph::model::Update> batch(std::size_t first, std::size_t most,
                                               const std::vector<MeshChoice>& meshes) const;
  /// `moving` nodes, the same ones each time or random ones, one step further.
  scenegraph::model::SetTransforms move(std::size_t moving, bool random, std::uint64_t step) const;
  /// The initial world position of that node.
  accel::geometry::Vec3d where(std::size_t n) const;

 private:
  struct Raster;
};

}  // namespace sightline::tests

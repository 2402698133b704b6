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
  std::size_t nodes = 1'000'000;  ///< With a mesh.
  std::size_t groups = 1000;      ///< Of equal size, a node each; 0: all nodes are roots.

  /// Nodes in all.
  std::size_t all_nodes() const { return nodes + groups; }
  /// The id of the n-th node with a mesh, in a scene that these nodes were put into first.
  scenegraph::model::NodeId id(std::size_t n) const;
  /// Of that node, and how far it stands from there in a step.
  scenegraph::model::Affine transform(std::size_t n, std::uint64_t step) const;
  /// The nodes from number `first` on, groups before what is in them, in batches of `most` at most;
  /// empty when there are none left. Ids of nodes put by batches before are taken for granted.
  std::vector<scenegraph::model::Update> batch(std::size_t first, std::size_t most,
                                               const std::vector<MeshChoice>& meshes) const;
  /// `moving` nodes, the same each time or random ones, a step further.
  scenegraph::model::SetTransforms move(std::size_t moving, bool random, std::uint64_t step) const;
  /// Where that node stands at first, in the world.
  accel::geometry::Vec3d where(std::size_t n) const;

 private:
  struct Raster;
};

}  // namespace sightline::tests

// Hierarchies with difficult boxes: deep, rotated, sheared, mirrored, far away, with empty nodes.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "scenegraph/scene.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

/// The kind of local transforms.
enum class Frames {
  kRigid,    ///< Rotation and translation.
  kSheared,  ///< In either orientation, with condition numbers up to 50.
  kFar,      ///< Rotation and translation by up to 1e7, in both directions.
  kFlat,     ///< One axis scaled down a thousandfold.
};

/// With a translation by up to `reach` (kFar: this many millions too).
scenegraph::model::Affine random_frame(Random& random, Frames frames, double reach = 4);

/// One of a few small meshes, by index; one has no triangles, and one has only non-finite ones.
std::shared_ptr<const scenegraph::model::Mesh> some_mesh(std::uint64_t index);

/// An update that puts a node under a random earlier node, or as a root, sometimes in a chain.
/// About half of the nodes have a mesh. Aliases are -1, -2, ...
std::vector<scenegraph::model::Update> random_hierarchy(int nodes, Frames frames,
                                                        std::uint64_t seed);

std::shared_ptr<const scenegraph::revision::Snapshot> snapshot_of(
    const std::vector<scenegraph::model::Update>& updates);

/// Between points of the scene's box, and from nearby toward instances.
std::vector<accel::geometry::Ray> rays_through(const scenegraph::revision::Snapshot& snapshot,
                                               std::size_t count, std::uint64_t seed);

/// `leaves` adjacent squares in a hierarchy of `fan` children each; a fan of 0: all under one node.
/// The square (x, y) of the grid of kSide(leaves) is [x, x + 1] x [y, y + 1].
std::shared_ptr<const scenegraph::revision::Snapshot> tiled_plane(std::size_t leaves,
                                                                  std::size_t fan);

}  // namespace sightline::tests

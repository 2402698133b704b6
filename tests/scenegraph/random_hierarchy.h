// Hierarchies that are hard on boxes: deep, turned, sheared, mirrored, far away, with nodes that
// hold nothing.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "scenegraph/scene.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

/// What the local transforms are like.
enum class Frames {
  kRigid,    ///< Turned and moved.
  kSheared,  ///< In either orientation, with conditions up to 50.
  kFar,      ///< Turned and moved by up to 1e7, there and back again.
  kFlat,     ///< One axis squeezed a thousandfold.
};

/// Moved by up to `reach` (kFar: by that many millions too).
scenegraph::model::Affine random_frame(Random& random, Frames frames, double reach = 4);

std::shared_ptr<const scenegraph::model::Mesh> to_mesh(const TestMesh& mesh);

/// A few small meshes, one without triangles and one with only such as are not finite. By place.
std::shared_ptr<const scenegraph::model::Mesh> some_mesh(std::uint64_t index);

/// One update that puts a node under any node put before it, or a root; a chain now and then. About
/// half of the nodes carry a mesh. Aliases are -1, -2, ...
std::vector<scenegraph::model::Update> random_hierarchy(int nodes, Frames frames,
                                                        std::uint64_t seed);

std::shared_ptr<const scenegraph::revision::Snapshot> snapshot_of(
    const std::vector<scenegraph::model::Update>& updates);

/// Between points of the scene's box, and from near by at instances.
std::vector<accel::geometry::Ray> rays_through(const scenegraph::revision::Snapshot& snapshot,
                                               std::size_t count, std::uint64_t seed);

/// `leaves` squares beside each other in a hierarchy of `fan` children each; a fan of 0: all under
/// one node. The square (x, y) of the grid of kSide(leaves) is that of [x, x + 1] x [y, y + 1].
std::shared_ptr<const scenegraph::revision::Snapshot> tiled_plane(std::size_t leaves,
                                                                  std::size_t fan);

}  // namespace sightline::tests

// The cells of a scene that rays have not built yet, for pictures of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph::revision {

struct DeferredCells {
  /// The boxes in the world: min x y z, max x y z; the largest first. Boxes in meshes are turned
  /// with their nodes, and are bounds of the turned boxes.
  std::vector<std::array<float, 6>> boxes;
  std::uint64_t total = 0;  ///< The number of all, also of those beyond the limit.
};

/// Finds the `limit` largest: cells of the scene's own trees, the cells of meshes that rays have
/// entered once for each node that has them, and meshes that no ray has met. Walks the scene
/// and what is built.
DeferredCells deferred_cells(const Snapshot& snapshot, std::size_t limit);

}  // namespace sightline::scenegraph::revision

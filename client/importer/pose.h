// The pose of an animated scene at one time: transforms and vertices of all that moves.
#pragma once

#include <cstdint>
#include <vector>

#include "client/importer/animation.h"

namespace sightline::client::importer {

struct Pose {
  struct Placed {
    std::uint32_t node = kNone;  ///< a node of the imported scene
    Transform parent_from_local = kIdentity;
  };
  struct Shaped {
    std::vector<std::uint32_t> nodes;  ///< nodes that have the same mesh, and share its new shape
    std::vector<Vertex> vertices;      ///< all vertices of the mesh, in its frame as imported
  };
  std::vector<Placed> placed;
  std::vector<Shaped> shaped;
};

/// Returns everything that the animation moves, in the frame of `animated.scene`, with the same
/// turn, scale and rebasing. Computed in double; vertices are rounded once, at the end. A skin is
/// applied in the frame of the node that has it, so that the bones determine where its vertices
/// are in the world, whatever moves that node.
Pose pose(const AnimatedScene& animated, const Animation& animation, double seconds);

}  // namespace sightline::client::importer

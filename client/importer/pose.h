// Where everything that moves in an animated scene is at one moment.
#pragma once

#include <cstdint>
#include <vector>

#include "client/importer/animation.h"

namespace sightline::client::importer {

struct Pose {
  struct Placed {
    std::uint32_t node = kNone;  ///< Of the imported scene.
    Transform parent_from_local = kIdentity;
  };
  struct Shaped {
    std::vector<std::uint32_t> nodes;  ///< That carry one mesh, and share its new shape.
    std::vector<Vertex> vertices;      ///< All of the mesh's, in its frame as imported.
  };
  std::vector<Placed> placed;
  std::vector<Shaped> shaped;
};

/// A scale nearer to zero is made this: no ray can be carried through a transform without an
/// inverse, but animations hide things by scaling them to nothing.
inline constexpr double kLeastScale = 1e-6;

/// Everything that the animation moves, in the frame of `animated.scene`: what was turned, scaled
/// and rebased there is so here. Computed in double; vertices are rounded once, at the end. A skin
/// is put on in the frame of the node that carries it, so that its vertices are in the world where
/// the bones take them, whatever moves that node.
Pose pose(const AnimatedScene& animated, const Animation& animation, double seconds);

}  // namespace sightline::client::importer

// A swarm: many small balls, each on a closed path of its own.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

inline constexpr std::uint64_t kTrianglesPerPart = 80;
inline constexpr std::size_t kSwarmFrames = 64;  ///< Then it comes round again.

/// Balls of 80 triangles (the last of fewer, so that there are exactly `triangles`), a root node
/// and a mesh each, in frame 0.
SceneSource make_swarm(std::uint64_t triangles);

/// Where the balls are in a frame, the same on every machine.
std::vector<scenegraph::model::Affine> swarm_places(std::size_t parts, std::size_t frame);

}  // namespace sightline::bench

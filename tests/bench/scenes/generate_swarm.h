// A swarm: many small balls, each on a closed path of its own.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

inline constexpr std::uint64_t kTrianglesPerPart = 80;
inline constexpr std::size_t kSwarmFrames = 64;  ///< Frames repeat after these.

/// Balls of 80 triangles (the last one of fewer, so that there are exactly `triangles`), each a
/// root node with its own mesh, in frame 0.
SceneSource make_swarm(std::uint64_t triangles);

/// The transforms of the balls in a frame; the same on every machine.
std::vector<scenegraph::model::Affine> swarm_transforms(std::size_t parts, std::size_t frame);

}  // namespace sightline::bench

// The costs that the rule of demand compares. docs/decisions/growth.md has the argument.
#pragma once

#include <cstdint>

namespace sightline::accel::lazy {

// The unit is what one ray spends on a reference by searching the list that has it. Measured by
// `sightline-bench calibrate`.

/// What a ray spends on beginning to search a list, or a mesh.
inline constexpr std::uint64_t kSearchStart = 700;
/// What one ray spends on searching a list.
constexpr std::uint64_t cost_of_search(std::uint64_t references) {
  return kSearchStart + references;
}

/// For each reference of a root: what the path of one ray through the tree costs to build, down to
/// leaf blocks. Each cell on it costs half of the one above.
inline constexpr std::uint64_t kPathCost = 12;
/// For each reference of a cell that is finished whole.
inline constexpr std::uint64_t kFinishCost = 110;
/// As above where triangles overlap so much that lists would not get shorter.
inline constexpr std::uint64_t kDenseCost = 150;
/// For each reference of a small mesh, which becomes leaf blocks without a division: no ray has
/// paid for one. And of leaf blocks that were evicted.
inline constexpr std::uint64_t kBlocksCost = 60;
/// For each reference of a list that is made again from ids.
inline constexpr std::uint64_t kListCost = 8;
/// Bytes of leaf blocks and wide nodes for each reference. No cost: to tell how much fits.
inline constexpr std::uint64_t kBytesOfReference = 72;
/// For each ray that walks a tree.
inline constexpr std::uint64_t kWalkCost = 75;

/// A cell that becomes leaf blocks is searched by fewer rays than this before. The divisions above
/// it have cost as much as the blocks will, so that these rays have paid already.
inline constexpr std::uint64_t kRaysToFinish = 2;

/// A cell is finished whole if rays would build at least this share of it piece by piece.
inline constexpr double kFinishShare = 0.5;

}  // namespace sightline::accel::lazy

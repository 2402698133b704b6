// The buffers of a build of blocks, kept for the next one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sightline::accel::blocks {

/// Most references of a set that is searched by exact sweeps; larger ones are binned.
inline constexpr std::size_t kSweptSet = 128;
/// 64-bit lanes of the widest vector: loads and stores may exceed a list by that many entries.
inline constexpr std::size_t kSpareRecords = 8;

/// The box of a reference: -lo.x, -lo.y, -lo.z, 0, hi.x, hi.y, hi.z, 0. The union of two is then
/// the maximum of all lanes.
struct alignas(32) BoxLanes {
  float lanes[8];
};

struct Workspace {
  std::vector<BoxLanes> boxes;  ///< The boxes of the references, clipped.
  std::vector<std::uint32_t> ids;
  /// Positions of references; a set is a consecutive part of them.
  std::vector<std::uint32_t> indices, moved;
  /// The records (record-inl.h) of a swept set in the order of their centers on each axis. They
  /// move from one buffer to the other as sets are divided.
  alignas(64) std::uint64_t orders[2][3][kSweptSet + 2 * kSpareRecords];

  void resize(std::size_t count) {
    if (count <= boxes.size()) return;
    boxes.resize(count);
    ids.resize(count);
    indices.resize(count);
    moved.resize(count);
  }
};

}  // namespace sightline::accel::blocks

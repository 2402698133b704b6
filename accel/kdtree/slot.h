// A slot: the 64-bit word for one child of a node: deferred cell, leaf or inner node.
// docs/node_layout.md has a drawing.
#pragma once

#include <bit>
#include <cassert>
#include <cstdint>

#include "accel/kdtree/reference.h"

namespace sightline::accel::kdtree {

struct DeferredCell;
class FinishedSubtree;

/// A child slot of 64 bits, always read and written as one atomic word:
///
///     tag, bits 0..2        bits 3..31           bits 32..63
///     deferred, expanding   the address of a DeferredCell (8-byte aligned)
///     leaf                  count                the reference if count is 1, else the index
///                                                of the first in the id array
///     finished              the address of a FinishedSubtree (8-byte aligned)
///     binary x, y, z        index of the pair    the plane's position, a float
///                           of child slots
///
/// The plane is in the slot that refers to the node, so an inner node is just its two child slots:
/// 16 bytes, one cache line.
class Slot {
 public:
  enum class Tag : std::uint64_t {
    kDeferred = 0,
    kExpanding = 1,
    kLeaf = 2,
    kFinished = 3,
    kBinaryX = 4,
    kBinaryY = 5,
    kBinaryZ = 6
  };

  static constexpr std::uint64_t kMaxPairs = std::uint64_t{1} << 29;
  static constexpr std::uint64_t kMaxLeafCount = (std::uint64_t{1} << 29) - 1;

  constexpr Slot() : bits_(static_cast<std::uint64_t>(Tag::kLeaf)) {}
  explicit constexpr Slot(std::uint64_t bits) : bits_(bits) {}

  static Slot deferred(const DeferredCell* cell) { return of(cell, Tag::kDeferred); }
  static Slot expanding(const DeferredCell* cell) { return of(cell, Tag::kExpanding); }
  static Slot finished(const FinishedSubtree* subtree) { return of(subtree, Tag::kFinished); }
  static constexpr Slot empty_leaf() { return Slot(); }
  static constexpr Slot single(std::uint32_t reference) { return leaf(1, reference); }
  static constexpr Slot leaf(std::uint64_t count, std::uint32_t first) {
    assert(count <= kMaxLeafCount);
    return Slot(static_cast<std::uint64_t>(Tag::kLeaf) | count << 3 | std::uint64_t{first} << 32);
  }
  static Slot binary(const Plane& plane, std::uint32_t pair) {
    assert(pair < kMaxPairs);
    return Slot(
        (static_cast<std::uint64_t>(Tag::kBinaryX) + static_cast<std::uint64_t>(plane.axis)) |
        std::uint64_t{pair} << 3 |
        std::uint64_t{std::bit_cast<std::uint32_t>(plane.position)} << 32);
  }

  constexpr std::uint64_t bits() const { return bits_; }
  constexpr bool operator==(const Slot&) const = default;

  constexpr Tag tag() const { return static_cast<Tag>(bits_ & 7); }
  constexpr bool is_binary() const { return (bits_ & 4) != 0; }
  constexpr bool is_leaf() const { return tag() == Tag::kLeaf; }
  constexpr bool is_finished() const { return tag() == Tag::kFinished; }
  /// Deferred or expanding: the slot holds a cell.
  constexpr bool is_deferred() const { return (bits_ & 7) <= 1; }

  int axis() const { return static_cast<int>(bits_ & 3); }
  float position() const { return std::bit_cast<float>(static_cast<std::uint32_t>(bits_ >> 32)); }
  std::uint32_t pair() const { return static_cast<std::uint32_t>(bits_) >> 3; }
  std::uint32_t leaf_count() const { return static_cast<std::uint32_t>(bits_) >> 3; }
  std::uint32_t leaf_first() const { return static_cast<std::uint32_t>(bits_ >> 32); }
  DeferredCell* cell() const { return std::bit_cast<DeferredCell*>(bits_ & ~std::uint64_t{7}); }
  const FinishedSubtree* finished() const {
    return std::bit_cast<const FinishedSubtree*>(bits_ & ~std::uint64_t{7});
  }

 private:
  static Slot of(const void* pointed, Tag tag) {
    const auto address = std::bit_cast<std::uint64_t>(pointed);
    assert((address & 7) == 0);
    return Slot(address | static_cast<std::uint64_t>(tag));
  }

  std::uint64_t bits_;
};

}  // namespace sightline::accel::kdtree

// A node of a wide tree: up to eight children, their boxes in columns.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>

#include "accel/kdtree/kd_tree.h"

namespace sightline::accel::wide {

inline constexpr std::size_t kWidth = 8;

struct WideNode;

/// What a child is: a node, a leaf block or a slot of the kd-tree. The address, with the kind in
/// its lowest bits; nothing if it is 0.
class Child {
 public:
  constexpr Child() = default;
  static Child node(const WideNode* node) { return Child(std::bit_cast<std::uint64_t>(node)); }
  /// `block`: the words of a blocks::Block.
  static Child block(const std::uint32_t* block) {
    return Child(std::bit_cast<std::uint64_t>(block) | kBlock);
  }
  static Child slot(const kdtree::AtomicSlot* slot) {
    return Child(std::bit_cast<std::uint64_t>(slot) | kSlot);
  }

  /// The word of a child, and the child of a word.
  std::uint64_t bits() const { return bits_; }
  static Child of(std::uint64_t bits) { return Child(bits); }

  explicit operator bool() const { return bits_ != 0; }
  bool is_node() const { return (bits_ & kKind) == 0; }
  bool is_block() const { return (bits_ & kBlock) != 0; }

  const WideNode* node() const {
    assert(is_node());
    return std::bit_cast<const WideNode*>(bits_);
  }
  const std::uint32_t* block() const {
    assert(is_block());
    return std::bit_cast<const std::uint32_t*>(bits_ & ~kKind);
  }
  kdtree::AtomicSlot* slot() const {
    assert((bits_ & kSlot) != 0);
    return std::bit_cast<kdtree::AtomicSlot*>(bits_ & ~kKind);
  }

 private:
  static constexpr std::uint64_t kBlock = 1, kSlot = 2, kKind = 3;
  explicit constexpr Child(std::uint64_t bits) : bits_(bits) {}

  std::uint64_t bits_;
};

/// Boxes are minus the center of their tree (blocks::frame_center). The box of a child that does
/// not exist begins at +inf and ends at -inf, so that no ray meets it.
struct alignas(64) WideNode {
  /// By axis: the lower bounds of all children, then the upper ones.
  std::array<std::array<float, kWidth>, 6> bounds;
  std::array<Child, kWidth> children;
};
static_assert(sizeof(WideNode) == 256);

/// Most nodes on a path in one tree; more would be too many for the stack of a walk.
inline constexpr std::size_t kMostLevels = 128;

}  // namespace sightline::accel::wide

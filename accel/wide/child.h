// Where rays go on in a tree.
#pragma once

#include <bit>
#include <cassert>
#include <cstdint>

#include "accel/kdtree/wide_node.h"

namespace sightline::accel::wide {

/// What a slot holds where that is final: a node or a leaf. Otherwise the slot itself, which is
/// read when rays come there: other threads replace what it holds. Nothing if it is 0.
class Child {
 public:
  constexpr Child() = default;
  /// What a slot leads to.
  static Child at(const kdtree::AtomicSlot& slot) {
    const kdtree::Slot now = kdtree::load(slot);
    return now.is_other() ? Child(std::bit_cast<std::uint64_t>(&slot) | kSlot) : final(now);
  }
  /// A node or a leaf.
  static Child final(kdtree::Slot slot) {
    assert(!slot.is_other());
    return Child(slot.bits());
  }

  /// The word of a child, and the child of a word.
  std::uint64_t bits() const { return bits_; }
  static Child of(std::uint64_t bits) { return Child(bits); }

  explicit operator bool() const { return bits_ != 0; }
  bool is_node() const { return (bits_ & kKind) == 0; }
  bool is_block() const { return (bits_ & kKind) == kBlock; }
  bool is_list() const { return (bits_ & kKind) == kList; }

  const kdtree::WideNode* node() const { return as_slot().node(); }
  /// The child of a node.
  Child child(std::size_t i) const {
    const kdtree::AtomicSlot& slot = node()->children[i];
    return as_slot().is_final_node() ? Child(kdtree::load(slot).bits()) : at(slot);
  }
  const std::uint32_t* block() const { return as_slot().words(); }
  std::span<const std::uint32_t> list() const { return as_slot().list(); }
  kdtree::AtomicSlot& slot() const {
    assert((bits_ & kKind) == kSlot);
    return *std::bit_cast<kdtree::AtomicSlot*>(bits_ & ~kKind);
  }

 private:
  static constexpr std::uint64_t kBlock = 1, kSlot = 2, kList = 3, kKind = 3;
  explicit constexpr Child(std::uint64_t bits) : bits_(bits) {}
  kdtree::Slot as_slot() const { return kdtree::Slot(bits_); }

  std::uint64_t bits_;  // Not set unless asked for: the stacks of walks are made for each ray.
};

}  // namespace sightline::accel::wide

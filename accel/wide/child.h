// The child of a node, as walks keep it on their stacks.
#pragma once

#include <bit>
#include <cassert>
#include <cstdint>

#include "accel/kdtree/wide_node.h"

namespace sightline::accel::wide {

/// A child of a node, as walks keep it: the node or leaf that a slot holds, if that is final; else
/// the address of the slot, which is read when rays come there, as other threads replace what it
/// holds. 0: nothing.
class Child {
 public:
  constexpr Child() = default;
  /// The child at a slot.
  static Child at(const kdtree::AtomicSlot& slot) {
    const kdtree::Slot now = kdtree::load(slot);
    return now.is_other() ? Child(std::bit_cast<std::uint64_t>(&slot) | kSlot) : final(now);
  }
  /// The child that is a node or a leaf.
  static Child final(kdtree::Slot slot) {
    assert(!slot.is_other());
    return Child(slot.bits());
  }

  /// Converts a child to a word, and a word to a child.
  std::uint64_t bits() const { return bits_; }
  static Child of(std::uint64_t bits) { return Child(bits); }

  explicit operator bool() const { return bits_ != 0; }
  bool is_node() const { return (bits_ & kKind) == 0; }
  bool is_block() const { return (bits_ & kKind) == kBlock; }
  bool is_list() const { return (bits_ & kKind) == kList; }

  const kdtree::WideNode* node() const { return as_slot().node(); }
  /// Child i of the node.
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

  std::uint64_t bits_;  // Uninitialized by default, as stacks of walks are made for each ray.
};

}  // namespace sightline::accel::wide

// A slot: the 64-bit word of one child: what is there, or the cell that it will be made of.
// docs/ray_path.md (node layout) has a drawing.
#pragma once

#include <atomic>
#include <bit>
#include <cassert>
#include <cstdint>
#include <span>

namespace sightline::accel::kdtree {

struct DeferredCell;
class FinishedSubtree;
struct WideNode;

/// A slot is read and written as one atomic word: an address, and in its lowest bits what is there.
/// Nothing is there if it is 0.
///
///     bits 0, 1   what the address is of
///     0           a WideNode, aligned to 64 bytes (bit 2: all below it is final)
///     1           the words of a leaf block (blocks/block.h), aligned to 4
///     2           a DeferredCell (bit 2: a thread expands it) or a FinishedSubtree (bit 3),
///                 aligned to 16
///     3           a list: the number of references, and their ids; 32-bit words, aligned to 4
class Slot {
 public:
  constexpr Slot() = default;
  explicit constexpr Slot(std::uint64_t bits) : bits_(bits) {}

  static Slot node(const WideNode* node) { return of(node, kNode); }
  /// The slot of a node below which there are only final nodes, blocks and lists.
  static Slot final_node(const WideNode* node) { return of(node, kNode | kFinal); }
  static Slot block(const std::uint32_t* words) { return of(words, kBlock); }
  static Slot list(const std::uint32_t* words) { return of(words, kList); }
  static Slot empty_list() {
    static constexpr std::uint32_t kNone = 0;
    return list(&kNone);
  }
  static Slot deferred(const DeferredCell* cell) { return of(cell, kOther); }
  static Slot expanding(const DeferredCell* cell) { return of(cell, kOther | kClaimed); }
  static Slot finished(const FinishedSubtree* subtree) { return of(subtree, kOther | kFinished); }

  constexpr std::uint64_t bits() const { return bits_; }
  constexpr bool operator==(const Slot&) const = default;
  explicit constexpr operator bool() const { return bits_ != 0; }

  constexpr bool is_node() const { return bits_ != 0 && (bits_ & kKind) == kNode; }
  constexpr bool is_final_node() const { return (bits_ & (kKind | kFinal)) == kFinal; }
  constexpr bool is_block() const { return (bits_ & kKind) == kBlock; }
  constexpr bool is_list() const { return (bits_ & kKind) == kList; }
  /// Whether the slot holds a cell or a finished subtree, which other threads may replace.
  constexpr bool is_other() const { return (bits_ & kKind) == kOther; }
  constexpr bool is_finished() const {
    return (bits_ & (kKind | kFinished)) == (kOther | kFinished);
  }
  /// Whether the slot holds a cell, also one that a thread expands.
  constexpr bool is_deferred() const { return (bits_ & (kKind | kFinished)) == kOther; }
  constexpr bool is_expanding() const { return is_deferred() && (bits_ & kClaimed) != 0; }

  const WideNode* node() const { return address<WideNode>(); }
  /// The words of a block or a list.
  const std::uint32_t* words() const { return std::bit_cast<const std::uint32_t*>(bits_ & ~kKind); }
  std::span<const std::uint32_t> list() const { return {words() + 1, *words()}; }
  DeferredCell* cell() const { return const_cast<DeferredCell*>(address<DeferredCell>()); }
  const FinishedSubtree* finished() const { return address<FinishedSubtree>(); }

 private:
  static constexpr std::uint64_t kKind = 3, kFinal = 4, kClaimed = 4, kFinished = 8, kLow = 15;
  static constexpr std::uint64_t kNode = 0, kBlock = 1, kOther = 2, kList = 3;

  static Slot of(const void* pointed, std::uint64_t tag) {
    const auto address = std::bit_cast<std::uint64_t>(pointed);
    assert((address & ((tag & kKind) == kBlock || (tag & kKind) == kList ? kKind : kLow)) == 0);
    return Slot(address | tag);
  }
  template <class T>
  const T* address() const {
    return std::bit_cast<const T*>(bits_ & ~kLow);
  }

  std::uint64_t bits_ = 0;
};

using AtomicSlot = std::atomic<std::uint64_t>;

inline Slot load(const AtomicSlot& slot) { return Slot(slot.load(std::memory_order_acquire)); }

}  // namespace sightline::accel::kdtree

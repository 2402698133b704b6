// Storage of a plain kd-tree, as the papers describe it: inner nodes in pairs, and the references
// of leaves.
#pragma once

#include <array>
#include <bit>
#include <cassert>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/kdtree/reference.h"

namespace sightline::accel::published::kd {

/// An inner node or a leaf, as one word:
///
///     bits 0..1    bit 2    bits 3..31                  bits 32..63
///     the axis     0        index of the pair below     the plane's position, a float
///     3: a leaf    failed   number of references        the reference if there is one, and it did
///                                                       not fail; else the index of the first
///
/// The plane is in the word that leads to the pair of children, left one first.
class PlainNode {
 public:
  static constexpr std::uint64_t kMostPairs = std::uint64_t{1} << 29;

  constexpr PlainNode() = default;  ///< An empty leaf.
  static PlainNode inner(const kdtree::Plane& plane, std::uint32_t pair) {
    assert(pair < kMostPairs);
    return PlainNode(static_cast<std::uint64_t>(plane.axis) | std::uint64_t{pair} << 3 |
                     std::uint64_t{std::bit_cast<std::uint32_t>(plane.position)} << 32);
  }
  static constexpr PlainNode leaf(std::size_t count, std::size_t first) {
    return PlainNode(kLeaf | std::uint64_t{count} << 3 | std::uint64_t{first} << 32);
  }
  /// Makes a leaf of a cell because there was no room for a cut, or for its ids.
  static constexpr PlainNode failed_leaf(std::size_t count, std::size_t first) {
    return PlainNode(leaf(count, first).bits_ | kFailed);
  }

  constexpr bool is_leaf() const { return (bits_ & kLeaf) == kLeaf; }
  constexpr bool is_failed() const { return (bits_ & kFailed) != 0; }
  constexpr std::size_t axis() const { return bits_ & 3; }
  constexpr std::uint32_t pair() const { return static_cast<std::uint32_t>(bits_) >> 3; }
  constexpr std::uint32_t count() const { return static_cast<std::uint32_t>(bits_) >> 3; }
  constexpr std::uint32_t first() const { return static_cast<std::uint32_t>(bits_ >> 32); }
  float position() const { return std::bit_cast<float>(first()); }

 private:
  static constexpr std::uint64_t kLeaf = 3, kFailed = 4;
  explicit constexpr PlainNode(std::uint64_t bits) : bits_(bits) {}

  std::uint64_t bits_ = kLeaf;
};

/// A whole tree.
struct PlainCells {
  using Pair = std::array<PlainNode, 2>;

  PlainNode root;
  std::vector<Pair> pairs;
  std::vector<std::uint32_t> ids;         ///< The ids of leaves with several references.
  std::vector<kdtree::Reference> failed;  ///< The references of failed leaves.

  /// The references of a leaf that did not fail. If there is only one, the span points to
  /// `storage`.
  std::span<const std::uint32_t> leaf(const PlainNode& node, std::uint32_t& storage) const {
    if (node.count() != 1) return {ids.data() + node.first(), node.count()};
    storage = node.first();
    return {&storage, 1};
  }
  std::span<const kdtree::Reference> failed_leaf(const PlainNode& node) const {
    return {failed.data() + node.first(), node.count()};
  }

  std::uint64_t bytes() const {
    return pairs.size() * sizeof(Pair) + ids.size() * sizeof(std::uint32_t) +
           failed.size() * sizeof(kdtree::Reference);
  }
};

}  // namespace sightline::accel::published::kd

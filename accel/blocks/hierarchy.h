// A binary tree whose leaves are blocks, or lists. It lives in an arena until it is compiled to
// wide nodes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <new>
#include <utility>

#include "accel/geometry/aabb.h"

namespace sightline::accel::blocks {

/// An inner node with two children, or a leaf: with a block (block.h), or with a list
/// (kdtree/slot.h).
struct Node {
  geometry::Aabb box;        ///< Bounds of the clipped references below, in mesh coordinates.
  std::uint32_t words = 0;   ///< Size of the block or list; 0 for an inner node.
  std::uint16_t levels = 0;  ///< 0 for a leaf; else 1 + the larger of the children's.
  std::uint16_t leaves = 1;  ///< Leaves in the subtree, at most kManyLeaves.
  union {
    const Node* left = nullptr;
    const std::uint32_t* leaf_words;
  };
  const Node* right = nullptr;

  /// `leaves` is not counted beyond this number.
  static constexpr unsigned kManyLeaves = 1024;
  bool leaf() const { return words != 0; }
};

/// A page of memory for which address translation is cheap.
inline constexpr std::size_t kHugePage = std::size_t{1} << 21;

/// Allocates memory in chunks whose size grows with what is allocated, so that little is unused.
/// Pointers stay valid as long as the object that owns the chunk. Threads: one at a time.
class Chunks {
 public:
  /// `most` is the largest size of a chunk in bytes, unless one piece needs more.
  explicit Chunks(std::size_t most) : most_(most) {}
  Chunks(Chunks&& other) noexcept : most_(other.most_) { append(std::move(other)); }
  Chunks& operator=(Chunks&& other) noexcept;
  Chunks(const Chunks&) = delete;
  Chunks& operator=(const Chunks&) = delete;
  ~Chunks() { free_all(); }

  /// Returns `size` uninitialized bytes, at least one, aligned to 16; kBlockSlack bytes behind them
  /// are readable. Throws std::bad_alloc.
  void* take(std::size_t size) {
    size = (size + kAlignment - 1) / kAlignment * kAlignment;
    if (size > left_) add(size);
    void* const taken = free_;
    free_ += size;
    left_ -= size;
    return taken;
  }

  /// Takes over the chunks of another object, which is empty then.
  void append(Chunks&& other) noexcept;
  /// Memory of all chunks.
  std::size_t bytes() const { return bytes_; }

 private:
  struct Chunk {
    Chunk* next;
  };
  static constexpr std::size_t kAlignment = 16;

  void add(std::size_t least);
  void free_all();

  std::size_t most_;
  Chunk *first_ = nullptr, *last_ = nullptr;
  std::byte* free_ = nullptr;  ///< The next free byte of a chunk, which has left_ of them.
  std::size_t left_ = 0;
  std::size_t bytes_ = 0;
};

/// Allocates nodes and blocks, each in chunks of their own, so that the blocks can be kept when the
/// nodes are compiled. Threads: one at a time.
class Arena {
 public:
  Node* node() { return new (nodes_.take(sizeof(Node))) Node; }
  /// Makes an inner node over two others.
  Node* join(const Node* left, const Node* right) {
    Node* const made = node();
    made->box = left->box;
    made->box.grow(right->box);
    made->levels = static_cast<std::uint16_t>(1 + std::max(left->levels, right->levels));
    made->leaves = static_cast<std::uint16_t>(
        std::min(unsigned{left->leaves} + right->leaves, Node::kManyLeaves));
    made->left = left;
    made->right = right;
    return made;
  }
  /// Allocates the words of a block; count > 0.
  std::uint32_t* words(std::size_t count) {
    return static_cast<std::uint32_t*>(words_.take(count * sizeof(std::uint32_t)));
  }

  /// Takes over what another arena has, which is empty then.
  void append(Arena&& other) noexcept {
    nodes_.append(std::move(other.nodes_));
    words_.append(std::move(other.words_));
  }
  /// Hands over the memory of the blocks.
  Chunks take_words() { return std::move(words_); }

  std::size_t bytes() const { return nodes_.bytes() + words_.bytes(); }
  std::size_t bytes_of_words() const { return words_.bytes(); }

 private:
  static constexpr std::size_t kMostNodeBytes = std::size_t{1} << 16;

  Chunks nodes_{kMostNodeBytes}, words_{kHugePage};
};

}  // namespace sightline::accel::blocks

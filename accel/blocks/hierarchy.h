// A binary tree whose leaves are blocks. It lives in an arena until it is compiled to wide nodes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <utility>

#include "accel/geometry/aabb.h"

namespace sightline::accel::blocks {

/// An inner node with two children, or a leaf: with a block (block.h), or with what its user knows.
struct Node {
  geometry::Aabb box;        ///< Of the clipped references below, in mesh coordinates.
  std::uint32_t words = 0;   ///< Of the block; 0: an inner node; kOther: a leaf without a block.
  std::uint16_t levels = 0;  ///< 0: a leaf; otherwise 1 + the larger of the children's.
  union {
    const Node* left = nullptr;
    const std::uint32_t* block;
    std::uint64_t other;
  };
  const Node* right = nullptr;

  static constexpr std::uint32_t kOther = ~std::uint32_t{0};
  bool leaf() const { return words != 0; }
};

/// Allocates nodes and blocks in chunks. Pointers stay valid as long as the arena that owns the
/// chunk. One thread at a time. Allocation throws std::bad_alloc.
class Arena {
 public:
  Arena() = default;
  Arena(Arena&& other) noexcept { append(std::move(other)); }
  Arena& operator=(Arena&& other) noexcept;
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;
  ~Arena() { free_chunks(); }

  Node* node() { return new (take(sizeof(Node))) Node; }
  /// Uninitialized, aligned to 16 bytes; kBlockSlack bytes behind them are readable. count > 0.
  std::uint32_t* words(std::size_t count) {
    return static_cast<std::uint32_t*>(take(count * sizeof(std::uint32_t)));
  }

  /// Takes over the chunks of another arena, which is empty then.
  void append(Arena&& other) noexcept;
  /// Memory of all chunks.
  std::size_t bytes() const { return bytes_; }

 private:
  struct Chunk {
    Chunk* next;
  };
  static constexpr std::size_t kAlignment = 16;

  void* take(std::size_t size) {
    size = (size + kAlignment - 1) / kAlignment * kAlignment;
    if (size > left_) add_chunk(size);
    void* const taken = free_;
    free_ += size;
    left_ -= size;
    return taken;
  }
  void add_chunk(std::size_t least);
  void free_chunks();

  Chunk *first_ = nullptr, *last_ = nullptr;
  std::byte* free_ = nullptr;  ///< In one of the chunks, with left_ bytes.
  std::size_t left_ = 0;
  std::size_t bytes_ = 0;
};

}  // namespace sightline::accel::blocks

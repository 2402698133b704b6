// Memory for the lists of an eager build: taken in order, released in reverse, never moved.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>
#include <vector>

namespace sightline::accel::grow {

/// Not shared between threads: every task has one.
template <class T>
class ListStack {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  struct Mark {
    std::size_t chunk, used;
  };

  Mark mark() const { return {chunk_, used_}; }
  void release(const Mark& m) {
    chunk_ = m.chunk;
    used_ = m.used;
  }

  /// Space for n items at the top, valid until released. Only items that are then taken are kept.
  /// Throws std::bad_alloc.
  T* top(std::size_t n) {
    while (chunk_ < chunks_.size() && chunks_[chunk_].size - used_ < n) {
      ++chunk_;
      used_ = 0;
    }
    if (chunk_ == chunks_.size()) {
      const std::size_t size = n > kChunk ? n : kChunk;
      chunks_.push_back({allocate(size), size});
    }
    return chunks_[chunk_].items.get() + used_;
  }
  void take(std::size_t n) { used_ += n; }

  std::uint64_t bytes() const {
    std::uint64_t sum = 0;
    for (const Chunk& c : chunks_) sum += c.size * sizeof(T);
    return sum;
  }

 private:
  static constexpr std::size_t kChunk = 8192;
  struct Free {
    void operator()(T* items) const { std::free(items); }
  };
  /// Not initialised, so that space that is reserved and not taken costs no memory.
  using Items = std::unique_ptr<T, Free>;
  struct Chunk {
    Items items;
    std::size_t size;
  };

  /// Asks for large pages for long lists, which are read and written from end to end.
  static Items allocate(std::size_t size) {
    constexpr std::size_t kLargePage = std::size_t{1} << 21;
    const std::size_t bytes = size * sizeof(T);
    const bool large = bytes >= 2 * kLargePage;
    const std::size_t alignment = large ? kLargePage : 64;
    const std::size_t padded = (bytes + alignment - 1) / alignment * alignment;
    void* items = std::aligned_alloc(alignment, padded);
    if (items == nullptr) throw std::bad_alloc();
    if (large) ::madvise(items, padded, MADV_HUGEPAGE);  // only a hint
    return Items(static_cast<T*>(items));
  }

  std::vector<Chunk> chunks_;
  std::size_t chunk_ = 0;
  std::size_t used_ = 0;
};

}  // namespace sightline::accel::grow

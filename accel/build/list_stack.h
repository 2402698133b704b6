// Room for the lists of an eager build: taken in order, given back in reverse, never moved.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <vector>

namespace sightline::accel {

/// Not shared between threads: every task has its own.
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

  /// Room for n items at the top. Valid until released; only what is then taken stays. Throws
  /// std::bad_alloc.
  T* top(std::size_t n) {
    while (chunk_ < chunks_.size() && chunks_[chunk_].size - used_ < n) {
      ++chunk_;
      used_ = 0;
    }
    if (chunk_ == chunks_.size()) {
      const std::size_t size = n > kChunk ? n : kChunk;
      chunks_.push_back({std::make_unique_for_overwrite<Raw[]>(size), size});
    }
    return reinterpret_cast<T*>(chunks_[chunk_].items.get()) + used_;
  }
  void take(std::size_t n) { used_ += n; }

  std::uint64_t bytes() const {
    std::uint64_t sum = 0;
    for (const Chunk& c : chunks_) sum += c.size * sizeof(T);
    return sum;
  }

 private:
  static constexpr std::size_t kChunk = 8192;
  /// T may have member initialisers; a chunk is left as the kernel gives it, so that room reserved
  /// and not taken costs no memory.
  struct alignas(T) Raw {
    std::byte bytes[sizeof(T)];
  };
  struct Chunk {
    std::unique_ptr<Raw[]> items;
    std::size_t size;
  };
  std::vector<Chunk> chunks_;
  std::size_t chunk_ = 0;
  std::size_t used_ = 0;
};

}  // namespace sightline::accel

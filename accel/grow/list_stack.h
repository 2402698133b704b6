// A stack of memory for the lists of an eager build. Memory is released in reverse order and never
// moved.
#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace sightline::accel::grow {

/// Threads: one; every task has its own.
template <class T>
class ListStack {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  struct Mark {
    std::size_t chunk, used;
  };

  /// `expected`: items that the stack will hold, with the room that top() asks for; 0: unknown. It
  /// may be far too many: memory is only used where items are written.
  explicit ListStack(std::size_t expected = 0) : expected_(expected) {}

  Mark mark() const { return {chunk_, used_}; }
  void release(const Mark& m) {
    chunk_ = m.chunk;
    used_ = m.used;
  }

  /// Memory for n items at the top of the stack, valid until the next top() or release(). take()
  /// keeps the first items. Throws std::bad_alloc.
  T* top(std::size_t n) {
    while (chunk_ < chunks_.size() && chunks_[chunk_].size() - used_ < n) {
      ++chunk_;
      used_ = 0;
    }
    if (chunk_ == chunks_.size())
      chunks_.emplace_back(std::max(n, chunks_.empty() && expected_ > 0 ? expected_ : kChunk));
    return chunks_[chunk_].items() + used_;
  }
  void take(std::size_t n) { used_ += n; }

  /// Whether trim() frees memory.
  bool is_large() const { return !chunks_.empty() && chunks_[0].is_mapped(); }
  /// Frees the memory above the top.
  void trim() {
    while (chunks_.size() > chunk_ + 1) chunks_.pop_back();
    if (chunk_ < chunks_.size()) chunks_[chunk_].free_from(used_);
  }

  /// Items from the bottom to the top, with those that no list fitted into.
  std::size_t size() const {
    std::size_t size = used_;
    for (std::size_t i = 0; i < chunk_; ++i) size += chunks_[i].size();
    return size;
  }

 private:
  static constexpr std::size_t kChunk = 8192;

  /// Not initialised, so that memory that is reserved and not written is never touched.
  class Chunk {
   public:
    explicit Chunk(std::size_t size) : size_(size), items_(allocate(size * sizeof(T))) {}
    Chunk(Chunk&& o) noexcept : size_(o.size_), items_(std::exchange(o.items_, nullptr)) {}
    Chunk& operator=(Chunk&&) = delete;
    ~Chunk() {
      if (items_ == nullptr) return;
      if (is_mapped()) {
        ::munmap(items_, size_ * sizeof(T));
      } else {
        std::free(items_);
      }
    }
    std::size_t size() const { return size_; }
    T* items() const { return items_; }
    bool is_mapped() const { return size_ * sizeof(T) >= kMapFrom; }

    /// Frees the pages behind the first n items of a large chunk. They can be written again.
    void free_from(std::size_t n) {
      if (!is_mapped()) return;
      constexpr std::size_t kPage = 4096;
      const std::size_t kept = (n * sizeof(T) + kPage - 1) / kPage * kPage;
      if (kept < size_ * sizeof(T))
        ::madvise(reinterpret_cast<std::byte*>(items_) + kept, size_ * sizeof(T) - kept,
                  MADV_DONTNEED);
    }

   private:
    static constexpr std::size_t kMapFrom = std::size_t{1} << 16;

    static T* allocate(std::size_t bytes) {
      if (bytes < kMapFrom) {
        void* const items = std::malloc(std::max<std::size_t>(bytes, 1));
        if (items == nullptr) throw std::bad_alloc();
        return static_cast<T*>(items);
      }
      void* const items = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                                 MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
      if (items == MAP_FAILED) throw std::bad_alloc();
      return static_cast<T*>(items);
    }

    std::size_t size_;
    T* items_;
  };

  std::size_t expected_;
  std::vector<Chunk> chunks_;
  std::size_t chunk_ = 0;
  std::size_t used_ = 0;
};

}  // namespace sightline::accel::grow

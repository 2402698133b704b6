// An array of zeros that allocates blocks when they are first used.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace sightline::scenegraph::instances {

/// `size` objects of a type whose initial value is zero, in blocks allocated at first access. An
/// array costs one pointer per block at first. Threads: all members, any, except moves.
template <class T>
class LazyArray {
 public:
  explicit LazyArray(std::size_t size) : blocks_((size + kPerBlock - 1) / kPerBlock), size_(size) {
    static_assert(std::is_trivially_destructible_v<T>);
  }
  LazyArray(LazyArray&& other) noexcept
      : blocks_(std::exchange(other.blocks_, {})), size_(std::exchange(other.size_, 0)) {}
  LazyArray& operator=(LazyArray&& other) noexcept {
    std::swap(blocks_, other.blocks_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~LazyArray() {
    for (const std::atomic<T*>& block : blocks_) delete[] block.load(std::memory_order_relaxed);
  }

  /// Throws std::bad_alloc at the first access to a block.
  T& operator[](std::size_t i) const {
    T* block = blocks_[i / kPerBlock].load(std::memory_order_acquire);
    if (block == nullptr) block = make(blocks_[i / kPerBlock]);
    return block[i % kPerBlock];
  }
  std::size_t size() const { return size_; }

 private:
  /// The number of objects in a page of memory.
  static constexpr std::size_t kPerBlock = std::max<std::size_t>(4096 / sizeof(T), 1);

  static T* make(std::atomic<T*>& block) {
    auto made = std::make_unique<T[]>(kPerBlock);
    T* now = nullptr;
    return block.compare_exchange_strong(now, made.get(), std::memory_order_acq_rel)
               ? made.release()
               : now;
  }

  mutable std::vector<std::atomic<T*>> blocks_;
  std::size_t size_;
};

}  // namespace sightline::scenegraph::instances

// An array that several owners share.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

namespace sightline::accel::kdtree {

/// An array whose copies share its items, which are written before it is copied and never after
/// that. Threads: one while it is written, then any.
template <class T>
class SharedArray {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  SharedArray() = default;
  /// Allocates `size` items, uninitialised. Throws std::bad_alloc.
  explicit SharedArray(std::size_t size) : head_(size > 0 ? allocate(nullptr, size) : nullptr) {
    if (head_ != nullptr) head_->owners = 1;
  }
  /// Copies the items. Throws std::bad_alloc.
  explicit SharedArray(std::span<const T> items) : SharedArray(items.size()) {
    std::copy(items.begin(), items.end(), all().begin());
  }
  SharedArray(const SharedArray& o) : head_(o.head_) {
    if (head_ != nullptr) owners().fetch_add(1, std::memory_order_relaxed);
  }
  SharedArray(SharedArray&& o) noexcept : head_(std::exchange(o.head_, nullptr)) {}
  SharedArray& operator=(SharedArray o) noexcept {
    std::swap(head_, o.head_);
    return *this;
  }
  ~SharedArray() {
    if (head_ != nullptr && owners().fetch_sub(1, std::memory_order_acq_rel) == 1) std::free(head_);
  }

  std::span<T> all() { return {items(), size()}; }
  std::span<const T> all() const { return {items(), size()}; }
  std::size_t size() const { return head_ == nullptr ? 0 : head_->size; }
  std::uint64_t bytes() const { return size() * sizeof(T); }

  /// Keeps the first `size` items, and frees the others' memory. Only before the array is copied.
  void shrink(std::size_t size) {
    if (size == 0) *this = SharedArray();
    if (size < this->size()) head_ = allocate(head_, size);
  }

 private:
  struct alignas(16) Head {
    std::size_t owners, size;
  };

  static Head* allocate(Head* old, std::size_t size) {
    auto* const head = static_cast<Head*>(std::realloc(old, sizeof(Head) + size * sizeof(T)));
    if (head == nullptr) throw std::bad_alloc();
    head->size = size;
    return head;
  }
  std::atomic_ref<std::size_t> owners() const { return std::atomic_ref(head_->owners); }
  T* items() const { return head_ == nullptr ? nullptr : reinterpret_cast<T*>(head_ + 1); }

  Head* head_ = nullptr;
};

}  // namespace sightline::accel::kdtree

// An array with its largest size reserved, which takes memory only as it is used. Addresses never
// change, so readers need no lock.
#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <new>
#include <utility>

namespace sightline::accel::published::bvh {

/// Reserves `capacity` trivial objects, uninitialised. A large array is address space only; the
/// kernel adds memory page by page on first use. Throws std::bad_alloc.
template <class T>
class ReservedArray {
 public:
  ReservedArray() = default;
  explicit ReservedArray(std::size_t capacity) : capacity_(capacity) {
    const std::size_t bytes = capacity * sizeof(T);
    if (bytes >= kMapFrom) {
      void* p = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                       MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
      if (p == MAP_FAILED) throw std::bad_alloc();
      // All of the front of a large array will be written, so large pages pay. A refusal costs only
      // time.
      if (bytes >= kHugeFrom) (void)::madvise(p, kHugeFrom, MADV_HUGEPAGE);
      data_ = static_cast<T*>(p);
    } else {
      constexpr std::size_t kAlign = std::max(alignof(T), alignof(std::max_align_t));
      data_ = static_cast<T*>(std::aligned_alloc(kAlign, (bytes / kAlign + 1) * kAlign));
      if (data_ == nullptr) throw std::bad_alloc();
    }
  }
  ReservedArray(ReservedArray&& o) noexcept
      : data_(std::exchange(o.data_, nullptr)), capacity_(std::exchange(o.capacity_, 0)) {}
  ReservedArray& operator=(ReservedArray&& o) noexcept {
    std::swap(data_, o.data_);
    std::swap(capacity_, o.capacity_);
    return *this;
  }
  ~ReservedArray() {
    if (data_ == nullptr) return;
    if (capacity_ * sizeof(T) >= kMapFrom) {
      ::munmap(data_, capacity_ * sizeof(T));
    } else {
      std::free(data_);
    }
  }

  T* data() const { return data_; }
  std::size_t capacity() const { return capacity_; }

 private:
  static constexpr std::size_t kMapFrom = std::size_t{1} << 18;
  static constexpr std::size_t kHugeFrom = std::size_t{1} << 26;
  T* data_ = nullptr;
  std::size_t capacity_ = 0;
};

}  // namespace sightline::accel::published::bvh

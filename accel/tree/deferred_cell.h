// A cell that is not built yet: its box, its list, and the state that lets one thread build it
// while others go on.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <utility>

// oneTBB 2021 calls it a preview; the interface has not changed since.
#define TBB_PREVIEW_COLLABORATIVE_CALL_ONCE 1
#include <tbb/collaborative_call_once.h>

#include "accel/build/box_ref.h"

namespace sightline::accel {

/// An owned list of references whose unused end can be given back.
class BoxList {
 public:
  BoxList() = default;
  /// Room for `size` boxes, uninitialised. Throws std::bad_alloc.
  explicit BoxList(std::size_t size) : data_(allocate(nullptr, size)), size_(size) {}

  std::span<BoxRef> all() { return {data_.get(), size_}; }
  std::span<const BoxRef> all() const { return {data_.get(), size_}; }
  std::size_t size() const { return size_; }
  std::uint64_t bytes() const { return size_ * sizeof(BoxRef); }

  /// Keeps the first `size` boxes.
  void shrink(std::size_t size) {
    data_.reset(allocate(data_.release(), size));
    size_ = size;
  }

 private:
  struct Free {
    void operator()(BoxRef* p) const { std::free(p); }
  };
  static BoxRef* allocate(BoxRef* old, std::size_t size) {
    void* p = std::realloc(old, (size > 0 ? size : 1) * sizeof(BoxRef));
    if (p == nullptr) throw std::bad_alloc();
    return static_cast<BoxRef*>(p);
  }
  std::unique_ptr<BoxRef, Free> data_;
  std::size_t size_ = 0;
};

/// Immutable but for `once` and `given_up` until it is retired; readers hold an epoch.
struct alignas(8) DeferredCell {
  Aabb box;
  CellPath path;
  /// The root's list is derived from the geometry by whoever expands it; until then `list` is empty
  /// and readers search all of the geometry.
  bool listed = true;
  BoxList list;
  std::size_t size = 0;  ///< References in the cell, listed or not.
  /// Expanding failed for want of memory: the cell stays as it is and is searched.
  std::atomic<bool> given_up{false};
  /// Large cells are expanded under this flag: latecomers join the work instead of waiting for it.
  tbb::collaborative_once_flag once;

  std::uint64_t bytes() const { return sizeof(DeferredCell) + list.bytes(); }
};

}  // namespace sightline::accel

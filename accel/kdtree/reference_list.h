// Lists of references as they are kept: short ones whole, long ones in pieces that several threads
// work on.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include "accel/kdtree/cell_memory.h"
#include "accel/kdtree/reference.h"

namespace sightline::accel::kdtree {

/// An owned list of references whose unused end can be given back.
class BoxList {
 public:
  BoxList() = default;
  /// Room for `size` boxes, uninitialised. Throws std::bad_alloc.
  explicit BoxList(std::size_t size) : data_(allocate(nullptr, size)), size_(size) {}
  /// A copy.
  explicit BoxList(std::span<const BoxRef> refs) : BoxList(refs.size()) {
    std::copy(refs.begin(), refs.end(), data_.get());
  }

  std::span<BoxRef> all() { return {data_.get(), size_}; }
  std::span<const BoxRef> all() const { return {data_.get(), size_}; }
  std::size_t size() const { return size_; }
  std::uint64_t bytes() const { return size_ * sizeof(BoxRef); }

  /// Keeps the first `size` boxes.
  void shrink(std::size_t size) {
    if (size == size_) return;
    data_.reset(allocate(data_.release(), size));
    size_ = size;
  }

 private:
  struct Free {
    void operator()(BoxRef* p) const { free_cell_memory(p); }
  };
  static BoxRef* allocate(BoxRef* old, std::size_t size) {
    void* p = reallocate_cell_memory(old, (size > 0 ? size : 1) * sizeof(BoxRef));
    if (p == nullptr) throw std::bad_alloc();
    return static_cast<BoxRef*>(p);
  }
  std::unique_ptr<BoxRef, Free> data_;
  std::size_t size_ = 0;
};

/// Lists of at least this many references are long: cells keep them in slices (SlicedList).
inline constexpr std::size_t kLongList = 8192;

/// A long list, immutable, in slices of about kBoxesPerSlice references. A slice is a few spans.
class SlicedList {
 public:
  using Piece = std::shared_ptr<const BoxList>;

  explicit SlicedList(std::vector<Piece> pieces);

  std::size_t size() const { return size_; }
  std::size_t slices() const { return slice_ends_.size(); }
  std::size_t slice_size(std::size_t slice) const;
  std::span<const std::span<const BoxRef>> slice(std::size_t slice) const;
  std::span<const std::span<const BoxRef>> all() const { return spans_; }
  /// The reference at a place in the list.
  const BoxRef& operator[](std::size_t place) const;
  std::uint64_t bytes() const { return size_ * sizeof(BoxRef); }

 private:
  std::vector<Piece> pieces_;
  std::vector<std::span<const BoxRef>> spans_;
  std::vector<std::size_t> slice_ends_;  // places in spans_
  std::size_t size_ = 0;
};

/// What a thread does at a time: with what comes of it, it stays in a core's second cache.
inline constexpr std::size_t kBoxesPerSlice = 4096;

/// Copies spans one behind the other.
BoxList join(std::span<const std::span<const BoxRef>> spans, std::size_t size);

/// The list of a cell that is not built.
class CellList {
 public:
  CellList() = default;
  explicit CellList(BoxList list) : short_(std::move(list)) {}
  explicit CellList(std::shared_ptr<const SlicedList> list) : long_(std::move(list)) {}

  std::size_t size() const { return long_ ? long_->size() : short_.size(); }
  std::uint64_t bytes() const { return long_ ? long_->bytes() : short_.bytes(); }

  /// Null for a short one.
  const std::shared_ptr<const SlicedList>& sliced() const { return long_; }
  /// Of a short one.
  std::span<const BoxRef> whole() const { return short_.all(); }

  /// Calls visit(span) for every part, until it returns true; returns whether it did.
  template <class Visit>
  bool any_part(const Visit& visit) const {
    if (!long_) return visit(short_.all());
    return std::any_of(long_->all().begin(), long_->all().end(), visit);
  }

  /// A copy in one piece.
  BoxList copy() const { return long_ ? join(long_->all(), long_->size()) : BoxList(short_.all()); }

 private:
  BoxList short_;
  std::shared_ptr<const SlicedList> long_;
};

}  // namespace sightline::accel::kdtree

// Lists of references. Short lists are one array, long lists are slices that several threads work
// on.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include "accel/kdtree/reference.h"

namespace sightline::accel::kdtree {

/// An owned array of references whose unused end can be freed.
class ReferenceList {
 public:
  ReferenceList() = default;
  /// Allocates `size` references, uninitialised. Throws std::bad_alloc.
  explicit ReferenceList(std::size_t size) : data_(allocate(nullptr, size)), size_(size) {}
  /// Copies the references.
  explicit ReferenceList(std::span<const Reference> refs) : ReferenceList(refs.size()) {
    std::copy(refs.begin(), refs.end(), data_.get());
  }

  std::span<Reference> all() { return {data_.get(), size_}; }
  std::span<const Reference> all() const { return {data_.get(), size_}; }
  std::size_t size() const { return size_; }
  std::uint64_t bytes() const { return size_ * sizeof(Reference); }

  /// Keeps the first `size` references, and frees the others' memory.
  void shrink(std::size_t size) {
    if (size == size_) return;
    data_.reset(allocate(data_.release(), size));
    size_ = size;
  }

 private:
  struct Free {
    void operator()(Reference* p) const { std::free(p); }
  };
  static Reference* allocate(Reference* old, std::size_t size) {
    void* p = std::realloc(old, (size > 0 ? size : 1) * sizeof(Reference));
    if (p == nullptr) throw std::bad_alloc();
    return static_cast<Reference*>(p);
  }
  std::unique_ptr<Reference, Free> data_;
  std::size_t size_ = 0;
};

/// Lists of at least this many references are long: cells keep them in slices (SlicedList).
inline constexpr std::size_t kLongList = 8192;

/// A long list, immutable, in slices of about kReferencesPerSlice references. A slice is a few
/// spans.
class SlicedList {
 public:
  using Piece = std::shared_ptr<const ReferenceList>;

  explicit SlicedList(std::vector<Piece> pieces);

  std::size_t size() const { return size_; }
  std::size_t slices() const { return slice_ends_.size(); }
  std::size_t slice_size(std::size_t slice) const;
  std::span<const std::span<const Reference>> slice(std::size_t slice) const;
  std::span<const std::span<const Reference>> all() const { return spans_; }
  /// The reference at an index of the list.
  const Reference& operator[](std::size_t index) const;
  std::uint64_t bytes() const { return size_ * sizeof(Reference); }

 private:
  std::vector<Piece> pieces_;
  std::vector<std::span<const Reference>> spans_;
  std::vector<std::size_t> slice_ends_;  // indices into spans_
  std::size_t size_ = 0;
};

/// References in a slice, which one thread works on at a time. A slice and its results fit in a
/// core's second-level cache.
inline constexpr std::size_t kReferencesPerSlice = 4096;

/// Copies spans into one list of `size` references.
ReferenceList join(std::span<const std::span<const Reference>> spans, std::size_t size);

/// The list of a deferred cell: short or long, or compact, ids alone.
class CellList {
 public:
  CellList() = default;
  explicit CellList(ReferenceList list) : short_(std::move(list)) {}
  explicit CellList(std::shared_ptr<const SlicedList> list) : long_(std::move(list)) {}
  /// Makes a compact list, which takes an eighth of the bytes. The source of the tree makes the
  /// references again.
  explicit CellList(std::vector<std::uint32_t> ids) : ids_(std::move(ids)) {}

  std::size_t size() const {
    if (is_compact()) return ids_.size();
    return long_ ? long_->size() : short_.size();
  }
  std::uint64_t bytes() const {
    if (is_compact()) return ids_.size() * sizeof(std::uint32_t);
    return long_ ? long_->bytes() : short_.bytes();
  }

  bool is_compact() const { return !ids_.empty(); }
  /// The ids of a compact list, which has none of what follows.
  std::span<const std::uint32_t> ids() const { return ids_; }

  /// The slices of a long list; null for a short list.
  const std::shared_ptr<const SlicedList>& sliced() const { return long_; }
  /// The references of a short list.
  std::span<const Reference> whole() const { return short_.all(); }

  /// Calls visit(span) for every part until one call returns true. Returns whether one did.
  template <class Visit>
  bool any_part(const Visit& visit) const {
    if (!long_) return visit(short_.all());
    return std::any_of(long_->all().begin(), long_->all().end(), visit);
  }

  /// A copy in one piece.
  ReferenceList copy() const {
    return long_ ? join(long_->all(), long_->size()) : ReferenceList(short_.all());
  }

 private:
  ReferenceList short_;
  std::shared_ptr<const SlicedList> long_;
  std::vector<std::uint32_t> ids_;
};

}  // namespace sightline::accel::kdtree

// Lists of references: short ones are one array, long ones are slices that several threads work on.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "accel/kdtree/reference.h"
#include "accel/kdtree/shared_array.h"

namespace sightline::accel::kdtree {

using ReferenceList = SharedArray<Reference>;

/// Lists of at least this many references are long.
inline constexpr std::size_t kLongList = 8192;

/// References in a slice, which one thread works on at a time. A slice and its results fit in a
/// core's second-level cache.
inline constexpr std::size_t kReferencesPerSlice = 4096;

/// A long list, immutable, in slices of kReferencesPerSlice references. A slice is a few spans.
class SlicedList {
 public:
  explicit SlicedList(std::vector<ReferenceList> pieces);

  std::size_t size() const { return size_; }
  std::size_t slices() const { return slice_ends_.size(); }
  std::span<const std::span<const Reference>> slice(std::size_t slice) const;
  std::span<const std::span<const Reference>> all() const { return spans_; }
  /// The reference at an index of the list.
  const Reference& operator[](std::size_t index) const;

 private:
  std::vector<ReferenceList> pieces_;
  std::vector<std::span<const Reference>> spans_;
  std::vector<std::size_t> slice_ends_;  // indices into spans_
  std::size_t size_ = 0;
};

/// The list of a deferred cell, immutable: short or long, or compact, ids alone. Copies share it.
class CellList {
 public:
  CellList() = default;
  explicit CellList(ReferenceList list);
  /// Joins pieces of a list to a short list, or keeps them as a long one. Throws std::bad_alloc.
  explicit CellList(std::vector<ReferenceList> pieces);
  /// Makes a compact list, which takes an eighth of the bytes. The source of the tree makes the
  /// references again.
  explicit CellList(SharedArray<std::uint32_t> ids) : ids_(std::move(ids)) {}

  std::size_t size() const {
    if (is_compact()) return ids_.size();
    return long_ ? long_->size() : short_.size();
  }
  std::uint64_t bytes() const { return is_compact() ? ids_.bytes() : size() * sizeof(Reference); }

  bool is_compact() const { return ids_.size() > 0; }
  /// The ids of a compact list, which has none of what follows.
  std::span<const std::uint32_t> ids() const { return ids_.all(); }

  /// A short list is one slice.
  std::size_t slices() const { return long_ ? long_->slices() : 1; }
  /// Calls visit(span) for each part of a slice.
  template <class Visit>
  void each_part(std::size_t slice, const Visit& visit) const {
    if (!long_) return visit(short_.all());
    for (const std::span<const Reference> part : long_->slice(slice)) visit(part);
  }
  /// Calls visit(span) for every part of the list until one call returns true. Returns whether one
  /// did.
  template <class Visit>
  bool any_part(const Visit& visit) const {
    if (!long_) return visit(short_.all());
    return std::any_of(long_->all().begin(), long_->all().end(), visit);
  }
  /// The reference at an index of the list.
  const Reference& operator[](std::size_t index) const {
    return long_ ? (*long_)[index] : short_.all()[index];
  }

 private:
  ReferenceList short_;
  std::shared_ptr<const SlicedList> long_;
  SharedArray<std::uint32_t> ids_;
};

}  // namespace sightline::accel::kdtree

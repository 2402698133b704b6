// Reads the references of a cell, whatever form its list has.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "accel/kdtree/deferred_cell.h"
#include "accel/lazy/reference_source.h"

namespace sightline::accel::lazy {

/// The references of a cell, in slices: those of its list; those that the ids of a compact list
/// stand for, made again; or the coarsest of the source, while the cell has no list. Shares all
/// that it reads, so it may outlive the cell. Threads: any, for all members.
class CellReader {
 public:
  CellReader(std::shared_ptr<const ReferenceSource> source, const kdtree::DeferredCell& cell,
             kdtree::BuildCounters& counters);

  /// The number of references, or an upper bound while there is no list.
  std::size_t size() const { return size_; }
  std::size_t slices() const {
    return is_in_memory() ? list_.slices()
                          : (size_ + kdtree::kReferencesPerSlice - 1) / kdtree::kReferencesPerSlice;
  }
  /// Whether references may be openable.
  bool openable() const { return openable_; }
  /// Whether the references are in memory, and need not be made.
  bool is_in_memory() const { return has_list_ && !list_.is_compact(); }
  /// The list, if the references are in memory.
  const kdtree::CellList& list() const { return list_; }

  /// Writes a slice; returns the number of its references.
  std::size_t read(std::size_t slice, kdtree::Reference* out,
                   kdtree::BuildCounters& counters) const;
  /// The references at these indices, without those that the source does not have. Throws
  /// std::bad_alloc.
  std::vector<kdtree::Reference> pick(std::span<const std::size_t> indices,
                                      kdtree::BuildCounters& counters) const;
  /// A copy in one piece, for the caller to overwrite. Throws std::bad_alloc, and Cancelled between
  /// two slices.
  kdtree::ReferenceList read_all(kdtree::BuildCounters& counters,
                                 const std::atomic<bool>* cancelled = nullptr) const;

 private:
  std::size_t make(std::size_t begin, std::size_t end, kdtree::Reference* out,
                   kdtree::BuildCounters& counters) const;

  std::shared_ptr<const ReferenceSource> source_;
  kdtree::CellList list_;
  std::size_t size_;
  bool has_list_, openable_;
};

}  // namespace sightline::accel::lazy

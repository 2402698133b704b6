// The lists of new cells, gathered from the slices of a pass.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "accel/kdtree/deferred_cell.h"
#include "accel/lazy/passes.h"

namespace sightline::accel::lazy {

/// Threads: one.
class NewLists {
 public:
  /// Adds the next slice. Throws std::bad_alloc.
  void add(PassSlice slice) {
    straddling_.openable += slice.straddling.openable;
    straddling_.all += slice.straddling.all;
    if (parts_.empty()) {
      parts_ = std::move(slice.parts);
      return;
    }
    later_.resize(parts_.size());
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      ListPart& part = slice.parts[i];
      parts_[i].first += part.first;
      parts_[i].openable |= part.openable;
      parts_[i].bounds.grow(part.bounds);
      later_[i].push_back(std::move(part.list));
    }
  }

  /// See ListPart::bounds.
  const geometry::Aabb& bounds(std::size_t i) const { return parts_[i].bounds; }
  const Straddling& straddling() const { return straddling_; }

  /// Gives list i to a cell. Call it once for each list. Throws std::bad_alloc.
  void move_to(kdtree::DeferredCell& cell, std::size_t i) {
    ListPart& part = parts_[i];
    if (later_.empty()) {
      cell.list = kdtree::CellList(std::move(part.list));
    } else {
      later_[i].insert(later_[i].begin(), std::move(part.list));
      cell.list = kdtree::CellList(std::move(later_[i]));
    }
    cell.first = part.first;
    cell.openable = part.openable;
    cell.size = cell.list.size();
    cell.weight = part.openable ? 0 : cell.size;
    if (!part.openable) return;
    cell.list.any_part([&](std::span<const kdtree::Reference> refs) {
      for (const kdtree::Reference& ref : refs) cell.weight += ref.weight;
      return false;
    });
  }

 private:
  std::vector<ListPart> parts_;  ///< The first slice's lists, and the counts of all slices.
  std::vector<std::vector<kdtree::ReferenceList>> later_;  ///< The lists of the others.
  Straddling straddling_;
};

}  // namespace sightline::accel::lazy

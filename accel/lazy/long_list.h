// A list in slices. The passes of a division over it are passes that any thread can help with.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "accel/lazy/divide.h"
#include "accel/lazy/partition.h"

namespace sightline::accel::lazy {

/// The lists of both children, from a short list or a long one.
struct ChildLists {
  ChildList left, right;
  Straddling straddling;
};

/// A long list as one thread sees it during one division. All members throw std::bad_alloc.
class LongList {
 public:
  LongList(const DivideContext& context, const kdtree::DeferredCell& cell, PassSequence& passes,
           kdtree::BuildCounters& counters)
      : context_(context),
        cell_(cell),
        list_(cell.list.sliced()),
        passes_(passes),
        counters_(counters) {}

  std::optional<kdtree::Split> choose();
  ChildLists sift(const PartitionInput& input);
  ChildList open();

 private:
  std::optional<kdtree::Split> choose_whole(kdtree::CellRefs refs);

  const DivideContext& context_;
  const kdtree::DeferredCell& cell_;
  const std::shared_ptr<const kdtree::SlicedList> list_;
  PassSequence& passes_;
  kdtree::BuildCounters& counters_;
};

/// The list of a root, made from the source.
ChildList list_root(const DivideContext& context, PassSequence& passes,
                    kdtree::BuildCounters& counters);

/// Pieces as a cell's list: sliced if it is long, else joined.
kdtree::CellList make_list(std::vector<kdtree::SlicedList::Piece> pieces);

}  // namespace sightline::accel::lazy

// A list in slices. The passes of a division over it are stages that any thread can help with.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "accel/lazy/divide.h"
#include "accel/lazy/sieve.h"

namespace sightline::accel::lazy {

/// The lists of both children, from a short list or a long one.
struct ChildLists {
  Part left, right;
  Straddling straddling;
};

/// A long list as one thread sees it during one division. All members throw std::bad_alloc.
class LongList {
 public:
  LongList(const DivideContext& context, const kdtree::DeferredCell& cell, Replay& replay,
           kdtree::BuildCounters& counters)
      : context_(context),
        cell_(cell),
        list_(cell.list.sliced()),
        replay_(replay),
        counters_(counters) {}

  std::optional<kdtree::Cut> choose();
  ChildLists sift(const Sieve& sieve);
  Part open();

 private:
  std::optional<kdtree::Cut> choose_whole(kdtree::CellRefs refs);

  const DivideContext& context_;
  const kdtree::DeferredCell& cell_;
  const std::shared_ptr<const kdtree::SlicedList> list_;
  Replay& replay_;
  kdtree::BuildCounters& counters_;
};

/// The list of a root, made from the source.
Part list_root(const DivideContext& context, Replay& replay, kdtree::BuildCounters& counters);

/// Pieces as a cell's list: sliced if it is long, else joined.
kdtree::CellList make_list(std::vector<kdtree::SlicedList::Piece> pieces);

}  // namespace sightline::accel::lazy

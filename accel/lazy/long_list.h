// A list in slices, with the operations of dividing as stages that any thread helps with.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "accel/grow/divide.h"
#include "accel/grow/sieve.h"

namespace sightline::accel {

/// One thread's view of it, for one division. All functions throw std::bad_alloc.
class LongList {
 public:
  LongList(const DivideContext& context, const DeferredCell& cell, Replay& replay,
           BuildCounters& counters)
      : context_(context),
        cell_(cell),
        list_(cell.list.sliced()),
        replay_(replay),
        counters_(counters) {}

  std::optional<Cut> choose();
  /// Sets the sides of the division.
  Straddling sift(const Sieve& sieve, Division& out);
  Part open();

 private:
  std::optional<Cut> choose_whole(CellRefs refs);

  const DivideContext& context_;
  const DeferredCell& cell_;
  const std::shared_ptr<const SlicedList> list_;
  Replay& replay_;
  BuildCounters& counters_;
};

/// The list of a root, made from the source.
Part list_root(const DivideContext& context, Replay& replay, BuildCounters& counters);

/// Pieces as a cell's list: sliced if it is long, else joined.
CellList make_list(std::vector<SlicedList::Piece> pieces);

}  // namespace sightline::accel

// The one place that decides between growing, searching and waiting.
#include "accel/lazy/cell_query.h"

namespace sightline::accel::lazy {

AtCell meet(LazyTree& tree, kdtree::AtomicSlot& slot, const kdtree::DeferredCell& cell,
            std::uint64_t rays, CellQuery& query, kdtree::BuildCounters& built) {
  if (tree.searches_hierarchy(cell)) return AtCell::kSearch;
  if (!may_grow(query.growth))
    return query.growth == Growth::kNone ? AtCell::kSearch : AtCell::kSkip;
  if (query.samples && tree.is_over_faces()) {
    query.awaited = {&tree, &slot};
    return AtCell::kStop;
  }
  if (tree.searches(cell, rays, query.growth == Growth::kDemand, built)) return AtCell::kSearch;
  const AtCell does = tree.expand(slot, built, query.cancelled, query.waits);
  if (does == AtCell::kAdvance) query.renew_pin();
  if (does == AtCell::kStop) query.progress = LazyTree::progress(slot);
  return does;
}

}  // namespace sightline::accel::lazy

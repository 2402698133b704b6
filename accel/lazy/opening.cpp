// Opening, with the test that sifting would have made.
#include "accel/lazy/opening.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace sightline::accel::lazy {

bool open_once(const ReferenceSource& source,
               std::span<const std::span<const kdtree::Reference>> spans,
               const geometry::Aabb& cell, kdtree::ReferenceList& out,
               kdtree::BuildCounters& counters) {
  std::vector<kdtree::Reference> finer;
  bool openable = false;
  for (const std::span<const kdtree::Reference> part : spans) {
    for (const kdtree::Reference& ref : part) {
      const std::size_t before = finer.size();
      if (!ref.openable()) {
        finer.push_back(ref);
        continue;
      }
      source.open(ref, finer, counters);
      counters.touches += finer.size() - before;
      const auto kept = std::remove_if(finer.begin() + static_cast<std::ptrdiff_t>(before),
                                       finer.end(), [&](const kdtree::Reference& r) {
                                         return r.weight == 0 || !is_member(r.bounds(), cell);
                                       });
      finer.erase(kept, finer.end());
      for (std::size_t i = before; i < finer.size(); ++i) openable |= finer[i].openable();
    }
  }
  out = kdtree::ReferenceList(finer);
  return openable;
}

kdtree::ReferenceList open_all(const ReferenceSource& source, kdtree::ReferenceList list,
                               const geometry::Aabb& cell, kdtree::BuildCounters& counters) {
  for (bool openable = true; openable;) {
    const std::span<const kdtree::Reference> refs = std::as_const(list).all();
    kdtree::ReferenceList finer;
    openable = open_once(source, {&refs, 1}, cell, finer, counters);
    list = std::move(finer);
  }
  return list;
}

}  // namespace sightline::accel::lazy

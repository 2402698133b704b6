// Opening, with the test that sifting would have made.
#include "accel/grow/opening.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace sightline::accel {

bool open_once(const ReferenceSource& source, std::span<const std::span<const BoxRef>> spans,
               const Aabb& cell, BoxList& out, BuildCounters& counters) {
  std::vector<BoxRef> finer;
  bool openable = false;
  for (const std::span<const BoxRef> part : spans) {
    for (const BoxRef& ref : part) {
      const std::size_t before = finer.size();
      if (!ref.openable()) {
        finer.push_back(ref);
        continue;
      }
      source.open(ref, finer, counters);
      counters.touches += finer.size() - before;
      const auto kept = std::remove_if(
          finer.begin() + static_cast<std::ptrdiff_t>(before), finer.end(),
          [&](const BoxRef& r) { return r.weight == 0 || !is_member(r.bounds(), cell); });
      finer.erase(kept, finer.end());
      for (std::size_t i = before; i < finer.size(); ++i) openable |= finer[i].openable();
    }
  }
  out = BoxList(finer);
  return openable;
}

BoxList open_all(const ReferenceSource& source, BoxList list, const Aabb& cell,
                 BuildCounters& counters) {
  for (bool openable = true; openable;) {
    const std::span<const BoxRef> refs = std::as_const(list).all();
    BoxList finer;
    openable = open_once(source, {&refs, 1}, cell, finer, counters);
    list = std::move(finer);
  }
  return list;
}

}  // namespace sightline::accel

// Opens references, and keeps those that are members of the cell.
#include "accel/lazy/opening.h"

#include <algorithm>
#include <utility>

namespace sightline::accel::lazy {

bool open_once(const ReferenceSource& source, std::span<const kdtree::Reference> refs,
               const geometry::Aabb& cell, std::vector<kdtree::Reference>& out,
               kdtree::BuildCounters& counters) {
  bool openable = false;
  for (const kdtree::Reference& ref : refs) {
    const std::size_t before = out.size();
    if (!ref.openable()) {
      out.push_back(ref);
      continue;
    }
    source.open(ref, out, counters);
    counters.touches += out.size() - before;
    const auto kept = std::remove_if(
        out.begin() + static_cast<std::ptrdiff_t>(before), out.end(),
        [&](const kdtree::Reference& r) { return r.weight == 0 || !is_member(r.bounds(), cell); });
    out.erase(kept, out.end());
    for (std::size_t i = before; i < out.size(); ++i) openable |= out[i].openable();
  }
  return openable;
}

kdtree::ReferenceList open_all(const ReferenceSource& source, kdtree::ReferenceList list,
                               const geometry::Aabb& cell, kdtree::BuildCounters& counters) {
  for (bool openable = true; openable;) {
    std::vector<kdtree::Reference> finer;
    openable = open_once(source, std::as_const(list).all(), cell, finer, counters);
    list = kdtree::ReferenceList(std::span<const kdtree::Reference>(finer));
  }
  return list;
}

}  // namespace sightline::accel::lazy

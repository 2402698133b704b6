// Search in O(N log N) per cell: sorts the ends of the boxes, then sweeps. Source: Wald, Havran
// 2006, algorithm 4.
#include <algorithm>
#include <memory>

#include "accel/published/kd/event.h"
#include "accel/published/kd/exact_search.h"
#include "accel/published/kd/sweep_axis.h"

namespace sightline::accel::published::kd {

Candidate search_sorted(const ExactCosts& costs, std::span<const kdtree::Reference> refs,
                        const geometry::Aabb& cell, std::uint32_t weight,
                        kdtree::BuildCounters& counters) {
  Candidate best;
  const auto storage = std::make_unique_for_overwrite<Event[]>(2 * refs.size());
  for (const int axis : {0, 1, 2}) {
    const auto a = static_cast<std::size_t>(axis);
    Event* end = storage.get();
    for (std::size_t i = 0; i < refs.size(); ++i) {
      end = put_events(refs[i].lo[a], refs[i].hi[a], static_cast<std::uint32_t>(i), end);
    }
    std::sort(storage.get(), end);
    const std::span<const Event> events(storage.get(), end);
    sweep_axis(events, AxisCuts(costs, cell, axis, weight), weight, ListWeights{refs}, best);
    counters.touches += refs.size() + sort_touches(events.size()) + events.size() / 2;
  }
  return best;
}

}  // namespace sightline::accel::published::kd

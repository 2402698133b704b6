// Search in O(N^2): one pass over the list for every bound of every box. Source: Wald, Havran 2006,
// algorithm 3.
#include "accel/published/kd/exact_search.h"

namespace sightline::accel::published::kd {
namespace {

/// Weight below, in, and above a plane; a straddler counts below and above.
struct Sides {
  std::uint32_t left = 0, planar = 0, right = 0;
};

Sides classify(std::span<const kdtree::Reference> refs, std::size_t axis, float x) {
  Sides sides;
  for (const kdtree::Reference& ref : refs) {
    if (is_planar(ref, axis)) {
      (ref.lo[axis] < x ? sides.left : ref.lo[axis] > x ? sides.right : sides.planar) += ref.weight;
    } else {
      sides.left += ref.lo[axis] < x ? ref.weight : 0;
      sides.right += ref.hi[axis] > x ? ref.weight : 0;
    }
  }
  return sides;
}

void offer(std::span<const kdtree::Reference> refs, const AxisCuts& cuts, std::size_t axis, float x,
           Candidate& best, kdtree::BuildCounters& counters) {
  const Sides n = classify(refs, axis, x);
  counters.touches += refs.size();
  const auto offer_side = [&](bool planar_left, std::uint32_t left, std::uint32_t right) {
    if (!cuts.leads_somewhere(x, planar_left, left, right)) return;
    const Candidate candidate = cuts.candidate(x, planar_left, left, right);
    if (candidate < best) best = candidate;
  };
  offer_side(false, n.left, n.right + n.planar);
  if (n.planar > 0) offer_side(true, n.left + n.planar, n.right);
}

}  // namespace

Candidate search_naively(const ExactCosts& costs, std::span<const kdtree::Reference> refs,
                         const geometry::Aabb& cell, std::uint32_t weight,
                         kdtree::BuildCounters& counters) {
  Candidate best;
  for (const int axis : {0, 1, 2}) {
    const auto a = static_cast<std::size_t>(axis);
    const AxisCuts cuts(costs, cell, axis, weight);
    for (const kdtree::Reference& ref : refs) {
      offer(refs, cuts, a, ref.lo[a], best, counters);
      if (!is_planar(ref, a)) offer(refs, cuts, a, ref.hi[a], best, counters);
    }
  }
  return best;
}

}  // namespace sightline::accel::published::kd

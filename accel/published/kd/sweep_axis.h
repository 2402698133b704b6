// One sweep over the sorted events of one axis: every candidate along it, in one pass.
// Source: Wald, Havran 2006, algorithms 4 and 5.
#pragma once

#include <cstdint>
#include <span>

#include "accel/published/kd/candidate.h"
#include "accel/published/kd/event.h"

namespace sightline::accel::published::kd {

/// Every reference weighs one: a triangle.
struct UnitWeights {
  std::uint32_t operator()(std::uint32_t) const { return 1; }
};

struct ListWeights {
  std::span<const kdtree::Reference> refs;
  std::uint32_t operator()(std::uint32_t reference) const { return refs[reference].weight; }
};

/// Improves `best` by the cuts of one axis; axes are to be swept in ascending order. `weight`: of
/// the whole cell. Touches: half the events, as a box has two ends.
///
/// Every event is weighed, not only the last at its position: before the ends at a position are all
/// counted the cost is too high, and after the first start it is too high again, so that the
/// smallest is the true one, and it comes first. That saves finding the groups, whose sizes no
/// processor can predict.
template <class Weights>
void sweep_axis(std::span<const Event> events, const AxisCuts& cuts, std::uint32_t weight,
                const Weights& weights, Candidate& best) {
  std::uint32_t left = 0, right = weight;
  const auto offer = [&](float x, bool planar_left) {
    if (!cuts.leads_somewhere(x, planar_left, left, right)) return;
    const Candidate candidate = cuts.candidate(x, planar_left, left, right);
    if (candidate.cost < best.cost) best = candidate;
  };
  for (std::size_t i = 0; i < events.size(); ++i) {
    const Event event = events[i];
    const float x = event.position();
    if (event.type() == EventType::kPlanar) {
      offer(x, false);
      for (;
           i < events.size() && events[i].position() == x && events[i].type() == EventType::kPlanar;
           ++i) {
        const std::uint32_t w = weights(events[i].reference());
        left += w;
        right -= w;
      }
      --i;
      offer(x, true);
      continue;
    }
    const std::uint32_t w = weights(event.reference());
    const bool ends = event.type() == EventType::kEnd;
    right -= ends ? w : 0;
    if (cuts.inside(x) && cuts.cost(x, left, right) < best.cost) offer(x, false);
    left += ends ? 0 : w;
  }
}

}  // namespace sightline::accel::published::kd

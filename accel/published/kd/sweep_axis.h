// One sweep over the sorted events of one axis evaluates every candidate along it.
// Source: Wald, Havran 2006, algorithms 4 and 5.
#pragma once

#include <cstdint>
#include <span>

#include "accel/published/kd/candidate.h"
#include "accel/published/kd/event.h"

namespace sightline::accel::published::kd {

/// Every reference is a triangle, of weight 1.
struct UnitWeights {
  std::uint32_t operator()(std::uint32_t) const { return 1; }
};

struct ListWeights {
  std::span<const kdtree::Reference> refs;
  std::uint32_t operator()(std::uint32_t reference) const { return refs[reference].weight; }
};

/// Improves `best` by the candidates of one axis. Call it for axes in ascending order. `weight` is
/// that of the whole cell. Touches: half the events, as a box has two ends.
///
/// The cost is computed at every event, not once per position. Before all ends at a position are
/// counted the cost is too high, and after the first start it is too high again, so the smallest is
/// the true one, and it comes first. This avoids a loop over events of equal position, whose number
/// is hard to predict.
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

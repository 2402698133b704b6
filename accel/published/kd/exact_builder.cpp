// The decision of the exact builders.
#include "accel/published/kd/exact_builder.h"

#include "accel/published/kd/event.h"
#include "accel/published/kd/exact_search.h"
#include "accel/split/out_of_range.h"

namespace sightline::accel::published::kd {

std::optional<std::string> ExactBuilder::check() const {
  if (auto e = split::out_of_range("cost_traverse", costs.traverse, 0.0, 1e6)) return e;
  if (auto e = split::out_of_range("cost_intersect", costs.intersect, 1e-6, 1e6)) return e;
  if (auto e = split::out_of_range("lambda", costs.lambda, 1e-6, 1.0)) return e;
  if (auto e = split::out_of_range("bad_refines", bad_refines, 0u, 16u)) return e;
  return std::nullopt;
}

std::optional<kdtree::Split> ExactBuilder::decide(const Candidate& best, std::uint32_t weight,
                                                  std::size_t references,
                                                  const kdtree::CellPath& path) const {
  if (best.cost <= costs.intersect * weight) return best.cut;
  const bool found = best.cost < std::numeric_limits<double>::infinity();
  if (!found || references < 2 || static_cast<std::uint32_t>(path.cuts_at_a_loss) >= bad_refines)
    return std::nullopt;
  kdtree::Split cut = best.cut;
  cut.at_a_loss = true;
  return cut;
}

std::optional<kdtree::Split> ExactBuilder::choose(const kdtree::CellRefs& list,
                                                  kdtree::BuildCounters& counters) const {
  const std::span<const kdtree::Reference> refs = list.refs;
  const geometry::Aabb& cell = list.box;
  // No ray meets a cell without area, so all planes in it are equal.
  if (refs.empty() || !(half_area(cell) > 0)) return std::nullopt;
  std::uint32_t weight = 0;
  for (const kdtree::Reference& ref : refs) weight += ref.weight;
  const bool naive = search == ExactSearch::kNaive || refs.size() > Event::kMaxReferences;
  const Candidate best = naive ? search_naively(costs, refs, cell, weight, counters)
                               : search_sorted(costs, refs, cell, weight, counters);
  return decide(best, weight, refs.size(), list.path);
}

}  // namespace sightline::accel::published::kd

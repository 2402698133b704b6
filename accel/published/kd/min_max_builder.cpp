// Chooses among the boundaries of bins.
#include "accel/published/kd/min_max_builder.h"

#include <algorithm>
#include <array>
#include <limits>

#include <tbb/task_arena.h>

#include "accel/published/kd/bins.h"
#include "accel/split/exhaustive_split.h"
#include "accel/split/out_of_range.h"

namespace sightline::accel::published::kd {
namespace {

/// There is no branch, as whether a bound lies inside a small cell is hard to predict.
bool is_inside(const geometry::Aabb& cell, std::size_t axis, float x) {
  return static_cast<bool>(static_cast<int>(x > cell.lo[axis]) &
                           static_cast<int>(x < cell.hi[axis]));
}

/// floor(log10 n), at least 1.
std::size_t stride_for(std::size_t n) {
  std::size_t stride = 0;
  for (; n >= 10; n /= 10) ++stride;
  return std::max<std::size_t>(stride, 1);
}

/// Calls offer(boundary, weight below, weight above) for every boundary, with sums over the bins:
/// boxes that start in a bin before it lie below it, boxes that end in a bin after it lie above it.
template <class Offer>
void for_each_boundary(const AxisBins& bins, std::uint32_t weight, const Offer& offer) {
  std::uint32_t left = 0, right = weight;
  for (std::uint32_t i = 0; i <= bins.size(); ++i) {
    offer(bins.boundary(i), left, right);
    if (i == bins.size()) break;
    left += bins.starts(i);
    right -= bins.ends(i);
  }
}

std::uint32_t total(const AxisBins& bins) {
  std::uint32_t sum = 0;
  for (std::uint32_t i = 0; i < bins.size(); ++i) sum += bins.starts(i);
  return sum;
}

/// Whether a plane keeps some reference out of one side.
bool separates(std::span<const kdtree::Reference> refs, std::size_t axis, float x) {
  return std::any_of(refs.begin(), refs.end(), [&](const kdtree::Reference& ref) {
    return !(ref.lo[axis] < x) || !(ref.hi[axis] > x);
  });
}

/// The split of the decomposition; nothing if it separates nothing.
std::optional<kdtree::Split> cut_at_median(const kdtree::CellRefs& list, std::uint32_t bins,
                                           kdtree::BuildCounters& counters) {
  const geometry::Aabb contents = content_bounds(list.refs, list.box);
  const auto axis = static_cast<std::size_t>(split::longest_axis(contents));
  AxisBins counted(contents.lo[axis], contents.hi[axis], bins);
  count_bins(list.refs, axis, counted);
  counters.touches += 2 * list.refs.size();
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  float x = contents.lo[axis];
  for_each_boundary(counted, total(counted),
                    [&](float at, std::uint32_t left, std::uint32_t right) {
                      const std::int64_t off = std::abs(std::int64_t{left} - std::int64_t{right});
                      if (off >= least || !is_inside(list.box, axis, at)) return;
                      least = off;
                      x = at;
                    });
  if (!is_inside(list.box, axis, x) || !separates(list.refs, axis, x)) return std::nullopt;
  return kdtree::Split{.plane = {static_cast<int>(axis), x}};
}

}  // namespace

std::optional<std::string> MinMaxBuilder::check() const {
  if (auto e = split::out_of_range("bins", bins, 2u, kMaxBins)) return e;
  if (auto e = split::out_of_range("threads", threads, 0u, 1024u)) return e;
  if (auto e = split::out_of_range("cost_traverse", cost.traverse, 0.0, 1e6)) return e;
  if (auto e = split::out_of_range("cost_intersect", cost.intersect, 1e-6, 1e6)) return e;
  if (auto e = split::out_of_range("empty_bonus", cost.empty_bonus, 1e-6, 1.0)) return e;
  return std::nullopt;
}

std::uint32_t MinMaxBuilder::threads_at(int depth) const {
  if (depth >= 10) return 0;  // 2^10 threads at most
  const auto all =
      threads > 0 ? threads : static_cast<std::uint32_t>(tbb::this_task_arena::max_concurrency());
  return all >> depth;
}

std::optional<kdtree::Split> MinMaxBuilder::choose(const kdtree::CellRefs& list,
                                                   kdtree::BuildCounters& counters) const {
  const std::span<const kdtree::Reference> refs = list.refs;
  const geometry::Aabb& cell = list.box;
  if (refs.empty()) return std::nullopt;
  if (const std::uint32_t here = threads_at(list.path.depth);
      here > 1 && refs.size() >= std::size_t{kDecompositionBins} * here) {
    if (const auto cut = cut_at_median(list, kDecompositionBins * here, counters)) return cut;
  }
  if (const auto rule = bound_rule(refs.size())) return choose_bound(refs, cell, *rule, counters);
  return choose_boundary(refs, cell, counters);
}

std::optional<kdtree::Split> MinMaxBuilder::choose_boundary(std::span<const kdtree::Reference> refs,
                                                            const geometry::Aabb& cell,
                                                            kdtree::BuildCounters& counters) const {
  const Sampling sampling{subsample ? stride_for(refs.size()) : 1};
  const geometry::Aabb contents = content_bounds(refs, cell);
  std::array<AxisBins, 3> counted;
  for (std::size_t a = 0; a < 3; ++a) counted[a] = AxisBins(contents.lo[a], contents.hi[a], bins);
  count_bins(refs, sampling, counted);
  counters.touches += refs.size() + sampling.size(refs.size());
  const std::uint32_t weight = total(counted[0]);
  const double each =
      static_cast<double>(refs.size()) / static_cast<double>(sampling.size(refs.size()));
  split::BestSplit best;
  for (const int axis : {0, 1, 2}) {
    const auto a = static_cast<std::size_t>(axis);
    const split::SplitAreas areas(cell, axis);
    for_each_boundary(counted[a], weight, [&](float x, std::uint32_t left, std::uint32_t right) {
      if (!is_inside(cell, a, x)) return;
      best.offer({axis, x},
                 split_cost(cost, areas, static_cast<double>(x), left * each, right * each));
    });
  }
  if (!best.found || !(best.cost < cost.intersect * weight * each)) return std::nullopt;
  return kdtree::Split{.plane = best.plane};
}

}  // namespace sightline::accel::published::kd

// Bins a list, divides it in place, and recurses.
#include "accel/published/bvh/binned_growth.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "accel/grow/fork.h"
#include "accel/published/bvh/center_bins.h"
#include "accel/published/bvh/halving.h"
#include "accel/split/cost_model.h"

namespace sightline::accel::published::bvh {
namespace {

/// Lists of at least this length are binned by several threads.
constexpr std::size_t kShareFrom = std::size_t{1} << 16;

ListSpan span_of(std::span<const kdtree::Reference> refs) {
  const auto add = [refs](const tbb::blocked_range<std::size_t>& range, ListSpan span) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) span.add(refs[i]);
    return span;
  };
  const tbb::blocked_range<std::size_t> all(0, refs.size(), kShareFrom / 4);
  if (refs.size() < kShareFrom) return add(all, {});
  return tbb::parallel_reduce(all, ListSpan{}, add, [](ListSpan a, const ListSpan& b) {
    a.grow(b);
    return a;
  });
}

/// Minima, maxima and integer sums, so the result does not depend on the slices.
void count(CenterBins& bins, std::span<const kdtree::Reference> refs) {
  if (refs.size() < kShareFrom) return bins.add(refs);
  const CenterBins none = bins;
  bins = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, refs.size(), kShareFrom / 4), none,
      [refs](const tbb::blocked_range<std::size_t>& range, CenterBins counted) {
        counted.add(refs.subspan(range.begin(), range.size()));
        return counted;
      },
      [](CenterBins a, const CenterBins& b) { return a += b; });
}

/// The lengths and bounds of a divided list.
struct Parts {
  std::size_t left = 0;
  std::array<ListSpan, 2> spans{};
};

class Growing {
 public:
  Growing(const BvhLeafRule& leaf, std::uint32_t bins, BvhGrowth& growth)
      : leaf_(leaf), bins_(bins), growth_(growth) {}

  BvhChild grow(std::span<kdtree::Reference> refs, const ListSpan& span, int depth,
                kdtree::BuildCounters& counters) {
    const geometry::Aabb box = span.boxes.aabb();
    if (refs.size() < 2) return growth_.leaf(refs, box);
    const std::optional<Parts> parts = divide(refs, span, box, depth, counters);
    if (!parts) return growth_.leaf(refs, box);
    std::array<BvhChild, 2> children;
    const auto below = [&](std::size_t side, kdtree::BuildCounters& its) {
      const auto list = side == 0 ? refs.first(parts->left) : refs.subspan(parts->left);
      children[side] = grow(list, parts->spans[side], depth + 1, its);
    };
    if (std::min(parts->left, refs.size() - parts->left) >= grow::kForkFrom) {
      kdtree::BuildCounters right;
      grow::fork([&] { below(0, counters); }, [&] { below(1, right); });
      counters += right;
    } else {
      below(0, counters);
      below(1, counters);
    }
    return growth_.inner(children[0], children[1]);
  }

 private:
  /// Divides a list; nothing if it becomes a leaf.
  std::optional<Parts> divide(std::span<kdtree::Reference> refs, const ListSpan& span,
                              const geometry::Aabb& box, int depth,
                              kdtree::BuildCounters& counters) const {
    if (refs.size() <= leaf_.leaf_size && !leaf_.split_small) return std::nullopt;
    counters.touches += 2 * refs.size();
    if (depth >= kHalvingDepth) {
      return halved(refs, static_cast<std::size_t>(split::longest_axis(box)));
    }
    const auto used = static_cast<std::uint32_t>(std::min<std::size_t>(bins_, refs.size()));
    CenterBins bins(span.centers, used);
    count(bins, refs);
    const BinSplit best = bins.best();
    if (leaf_.keeps(refs.size(), half_area(box), best.found ? best.sum : kInfiniteSum))
      return std::nullopt;
    if (!best.found) return halved(refs, 0);
    return divided(refs, bins, best);
  }

  static Parts halved(std::span<kdtree::Reference> refs, std::size_t axis) {
    Parts parts{.left = halve_by_center(refs, axis)};
    parts.spans = {span_of(refs.first(parts.left)), span_of(refs.subspan(parts.left))};
    return parts;
  }

  /// Partitions from both ends, and computes the bounds of both sides on the way.
  static Parts divided(std::span<kdtree::Reference> refs, const CenterBins& bins,
                       const BinSplit& split) {
    Parts parts;
    std::size_t i = 0, end = refs.size();
    while (i < end) {
      const bool left = bins.goes_left(refs[i], split);
      parts.spans[left ? 0 : 1].add(refs[i]);
      if (left) {
        ++i;
      } else {
        std::swap(refs[i], refs[--end]);
      }
    }
    parts.left = i;
    return parts;
  }

  static constexpr double kInfiniteSum = std::numeric_limits<double>::infinity();

  const BvhLeafRule& leaf_;
  std::uint32_t bins_;
  BvhGrowth& growth_;
};

}  // namespace

BvhChild grow_binned(std::span<kdtree::Reference> refs, const BvhLeafRule& leaf, std::uint32_t bins,
                     BvhGrowth& growth, kdtree::BuildCounters& counters) {
  const ListSpan span = span_of(refs);
  counters.touches += refs.size();
  return Growing(leaf, bins, growth).grow(refs, span, 0, counters);
}

}  // namespace sightline::accel::published::bvh

// Counts centers in bins, divides a list in place at the cheapest boundary, and recurses.
#include "accel/published/bvh/binned_growth.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "accel/grow/fork.h"
#include "accel/kdtree/reference.h"
#include "accel/split/cost_model.h"

namespace sightline::accel::published::bvh {
namespace {

/// The middle of a box along an axis; finite for finite boxes.
float center(const kdtree::Reference& ref, std::size_t axis) {
  return 0.5f * ref.lo[axis] + 0.5f * ref.hi[axis];
}

/// Partitions by center, then by id: the lower half first. Returns the length of the first half.
std::size_t halve_by_center(std::span<kdtree::Reference> refs, std::size_t axis) {
  const std::size_t half = refs.size() / 2;
  std::nth_element(refs.begin(), refs.begin() + static_cast<std::ptrdiff_t>(half), refs.end(),
                   [axis](const kdtree::Reference& a, const kdtree::Reference& b) {
                     const float x = center(a, axis), y = center(b, axis);
                     return x != y ? x < y : a.id < b.id;
                   });
  return half;
}

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

/// Bins hold minima, maxima and integer sums, so the result does not depend on the slices.
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
    if (leaf_.keeps(refs.size(), half_area(box), best.sum)) return std::nullopt;
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

  const BvhLeafRule& leaf_;
  std::uint32_t bins_;
  BvhGrowth& growth_;
};

Lanes middle(Lanes lo, Lanes hi) { return lo * all_lanes(0.5f) + hi * all_lanes(0.5f); }

}  // namespace

BvhChild grow_binned(std::span<kdtree::Reference> refs, const BvhLeafRule& leaf, std::uint32_t bins,
                     BvhGrowth& growth, kdtree::BuildCounters& counters) {
  const ListSpan span = span_of(refs);
  counters.touches += refs.size();
  return Growing(leaf, bins, growth).grow(refs, span, 0, counters);
}

void ListSpan::add(const kdtree::Reference& ref) {
  const Lanes lo = lanes(ref.lo), hi = lanes(ref.hi);
  boxes.grow(lo, hi);
  centers.grow(middle(lo, hi));
}

CenterBins::CenterBins(const LaneBox& centers, std::uint32_t bins)
    : last_(static_cast<float>(bins - 1)), bins_(bins) {
  const LaneBox none;
  assert(bins >= 2 && bins <= kMaxBins);
  for (std::size_t a = 0; a < 3; ++a) {
    const auto lane = static_cast<int>(a);
    lo_[a] = centers.lo[lane];
    const double extent =
        static_cast<double>(centers.hi[lane]) - static_cast<double>(centers.lo[lane]);
    // An extent whose inverse is not a finite float has no bins.
    const double per_width = extent > 0 ? bins / extent : 0;
    per_width_[a] = per_width < 1e38 ? static_cast<float>(per_width) : 0;
    if (per_width_[a] > 0) std::fill_n(counted_[a].begin(), bins, Bin{none.lo, none.hi, 0});
  }
}

void CenterBins::add(std::span<const kdtree::Reference> refs) {
  for (const kdtree::Reference& ref : refs) {
    const Lanes lo = lanes(ref.lo), hi = lanes(ref.hi);
    for (std::size_t a = 0; a < 3; ++a) {
      if (!(per_width_[a] > 0)) continue;
      Bin& into = counted_[a][bin(center(ref, a), a)];
      into.lo = least(lo, into.lo);
      into.hi = greatest(hi, into.hi);
      ++into.count;
    }
  }
}

CenterBins& CenterBins::operator+=(const CenterBins& o) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(per_width_[a] > 0)) continue;
    for (std::size_t b = 0; b < bins_; ++b) {
      counted_[a][b].lo = least(counted_[a][b].lo, o.counted_[a][b].lo);
      counted_[a][b].hi = greatest(counted_[a][b].hi, o.counted_[a][b].hi);
      counted_[a][b].count += o.counted_[a][b].count;
    }
  }
  return *this;
}

BinSplit CenterBins::best() const {
  BinSplit best;
  std::array<double, kMaxBins> from;  // cost of all bins from this one on
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(per_width_[a] > 0)) continue;
    const auto& counted = counted_[a];
    LaneBox right;
    std::uint64_t n = 0;
    for (std::size_t b = bins_ - 1; b > 0; --b) {
      right.grow(counted[b].lo, counted[b].hi);
      n += counted[b].count;
      from[b] = n > 0 ? half_area(right.aabb()) * static_cast<double>(n) : -1;
    }
    LaneBox left;
    n = 0;
    for (std::uint32_t b = 0; b + 1 < bins_; ++b) {
      left.grow(counted[b].lo, counted[b].hi);
      n += counted[b].count;
      if (n == 0 || from[b + 1] < 0) continue;
      const double sum = half_area(left.aabb()) * static_cast<double>(n) + from[b + 1];
      if (best.found && !(sum < best.sum)) continue;
      best = {.axis = a, .last_left = b, .sum = sum, .found = true};
    }
  }
  return best;
}

bool CenterBins::goes_left(const kdtree::Reference& ref, const BinSplit& split) const {
  return bin(center(ref, split.axis), split.axis) <= split.last_left;
}

}  // namespace sightline::accel::published::bvh

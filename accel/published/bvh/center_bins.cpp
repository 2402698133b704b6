// Counts centers in bins, and finds the cheapest boundary.
#include "accel/published/bvh/center_bins.h"

#include <algorithm>
#include <cassert>

#include "accel/published/bvh/halving.h"

namespace sightline::accel::published::bvh {
namespace {

Lanes middle(Lanes lo, Lanes hi) { return lo * all_lanes(0.5f) + hi * all_lanes(0.5f); }

}  // namespace

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

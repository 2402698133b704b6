// Binning centers, and weighing the boundaries.
#include "accel/bvh/center_bins.h"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "accel/bvh/halving.h"

namespace sightline::accel {
namespace {

struct Lanes {
  std::array<float, 4> lo, hi;
};
/// The fourth lanes are the id and the weight, which nobody looks at.
Lanes lanes(const BoxRef& ref) {
  Lanes l;
  static_assert(sizeof l == sizeof ref);
  std::memcpy(static_cast<void*>(&l), &ref, sizeof l);
  return l;
}

}  // namespace

void ListSpan::add(const BoxRef& ref) {
  const Lanes l = lanes(ref);
  boxes.grow(l.lo, l.hi);
  std::array<float, 4> c;
  for (std::size_t i = 0; i < 4; ++i) c[i] = 0.5f * l.lo[i] + 0.5f * l.hi[i];
  centers.grow(c, c);
}

CenterBins::CenterBins(const BinBox& centers, std::uint32_t bins)
    : last_(static_cast<float>(bins - 1)), bins_(bins) {
  assert(bins >= 2 && bins <= kMaxBins);
  for (std::size_t a = 0; a < 3; ++a) {
    lo_[a] = centers.lo[a];
    const double extent = static_cast<double>(centers.hi[a]) - static_cast<double>(centers.lo[a]);
    // So small an extent that its inverse is no float has no bins.
    const double per_width = extent > 0 ? bins / extent : 0;
    per_width_[a] = per_width < 1e38 ? static_cast<float>(per_width) : 0;
    if (per_width_[a] > 0) std::fill_n(counted_[a].begin(), bins, Bin{BinBox::none(), 0});
  }
}

void CenterBins::add(std::span<const BoxRef> refs) {
  for (const BoxRef& ref : refs) {
    const Lanes l = lanes(ref);
    for (std::size_t a = 0; a < 3; ++a) {
      if (!(per_width_[a] > 0)) continue;
      Bin& into = counted_[a][bin(0.5f * l.lo[a] + 0.5f * l.hi[a], a)];
      into.box.grow(l.lo, l.hi);
      ++into.count;
    }
  }
}

CenterBins& CenterBins::operator+=(const CenterBins& o) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(per_width_[a] > 0)) continue;
    for (std::size_t b = 0; b < bins_; ++b) {
      counted_[a][b].box.grow(o.counted_[a][b].box);
      counted_[a][b].count += o.counted_[a][b].count;
    }
  }
  return *this;
}

BinSplit CenterBins::best() const {
  BinSplit best;
  std::array<double, kMaxBins> from;  // of all bins from there on
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(per_width_[a] > 0)) continue;
    const auto& counted = counted_[a];
    BinBox right = BinBox::none();
    std::uint64_t n = 0;
    for (std::size_t b = bins_ - 1; b > 0; --b) {
      right.grow(counted[b].box);
      n += counted[b].count;
      from[b] = n > 0 ? half_area(right.aabb()) * static_cast<double>(n) : -1;
    }
    BinBox left = BinBox::none();
    n = 0;
    for (std::uint32_t b = 0; b + 1 < bins_; ++b) {
      left.grow(counted[b].box);
      n += counted[b].count;
      if (n == 0 || from[b + 1] < 0) continue;
      const double sum = half_area(left.aabb()) * static_cast<double>(n) + from[b + 1];
      if (best.found && !(sum < best.sum)) continue;
      best = {.axis = a, .last_left = b, .sum = sum, .found = true};
    }
  }
  return best;
}

bool CenterBins::goes_left(const BoxRef& ref, const BinSplit& split) const {
  return bin(center(ref, split.axis), split.axis) <= split.last_left;
}

}  // namespace sightline::accel

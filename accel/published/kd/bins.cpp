// Counts boxes in bins.
#include "accel/published/kd/bins.h"

#include <algorithm>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

namespace sightline::accel::published::kd {
namespace {

/// Lists of at least twice this length are counted in parallel slices of this length.
constexpr std::size_t kSlice = 32768;

/// `add` counts the items from begin to end into a sum that starts at zero; `join` adds the sums of
/// slices.
template <class Sum, class Add, class Join>
void count_in_slices(std::size_t items, Sum& sum, const Add& add, const Join& join) {
  if (items < 2 * kSlice) return add(0, items, sum);
  sum = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, items, kSlice), sum,
      [&](const tbb::blocked_range<std::size_t>& slice, Sum of_slice) {
        add(slice.begin(), slice.end(), of_slice);
        return of_slice;
      },
      [&](Sum a, const Sum& b) {
        join(a, b);
        return a;
      });
}

void grow_bounds(std::span<const kdtree::Reference> refs, geometry::Aabb& bounds) {
  for (const kdtree::Reference& ref : refs) {
    for (std::size_t a = 0; a < 3; ++a) {
      bounds.lo[a] = std::min(bounds.lo[a], ref.lo[a]);
      bounds.hi[a] = std::max(bounds.hi[a], ref.hi[a]);
    }
  }
}

}  // namespace

AxisBins::AxisBins(float lo, float hi, std::uint32_t bins)
    : lo_(lo),
      hi_(hi),
      width_((static_cast<double>(hi) - static_cast<double>(lo)) / bins),
      per_width_(static_cast<float>(1 / width_)),
      last_(static_cast<float>(bins - 1)),
      counts_(bins) {}

AxisBins& AxisBins::operator+=(const AxisBins& o) {
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    counts_[i].starts += o.counts_[i].starts;
    counts_[i].ends += o.counts_[i].ends;
  }
  return *this;
}

geometry::Aabb content_bounds(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell) {
  geometry::Aabb bounds;
  count_in_slices(
      refs.size(), bounds,
      [&](std::size_t begin, std::size_t end, geometry::Aabb& sum) {
        grow_bounds(refs.subspan(begin, end - begin), sum);
      },
      [](geometry::Aabb& a, const geometry::Aabb& b) { a.grow(b); });
  return geometry::common(bounds, cell);
}

void count_bins(std::span<const kdtree::Reference> refs, const Sampling& sampling,
                std::array<AxisBins, 3>& axes) {
  count_in_slices(
      sampling.size(refs.size()), axes,
      [&](std::size_t begin, std::size_t end, std::array<AxisBins, 3>& sum) {
        for (std::size_t k = begin; k < end; ++k) {
          const kdtree::Reference& ref = refs[sampling.at(k, refs.size())];
          for (std::size_t a = 0; a < 3; ++a) sum[a].add(ref.lo[a], ref.hi[a], ref.weight);
        }
      },
      [](std::array<AxisBins, 3>& x, const std::array<AxisBins, 3>& y) {
        for (std::size_t a = 0; a < 3; ++a) x[a] += y[a];
      });
}

void count_bins(std::span<const kdtree::Reference> refs, std::size_t axis, AxisBins& bins) {
  count_in_slices(
      refs.size(), bins,
      [&](std::size_t begin, std::size_t end, AxisBins& sum) {
        for (const kdtree::Reference& ref : refs.subspan(begin, end - begin))
          sum.add(ref.lo[axis], ref.hi[axis], ref.weight);
      },
      [](AxisBins& x, const AxisBins& y) { x += y; });
}

}  // namespace sightline::accel::published::kd

// Sorts points by the bits of their coordinates, interleaved.
#include "scenegraph/query/point_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <tbb/parallel_sort.h>

#include "scenegraph/query/morton.h"

namespace sightline::scenegraph::query {
namespace {

/// Bits of each coordinate.
constexpr int kBits = 10;
constexpr double kUnit = 1, kNone = 0;

/// The box of all finite coordinates.
struct Extent {
  std::array<double, 3> lo, hi;

  explicit Extent(const accel::geometry::RayColumns& points) {
    lo.fill(std::numeric_limits<double>::infinity());
    hi.fill(-std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < points.size; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double x = points.origin[axis][i];
        if (!std::isfinite(x)) continue;
        lo[axis] = std::min(lo[axis], x);
        hi[axis] = std::max(hi[axis], x);
      }
    }
  }

  std::uint64_t part_of(double x, std::size_t axis) const {
    const double share = (x - lo[axis]) / (hi[axis] - lo[axis]);
    // Also for an extent of 0, and coordinates that are not numbers.
    if (!(share > 0)) return 0;
    return static_cast<std::uint64_t>(std::min(share, 1.0) * ((1 << kBits) - 1));
  }
};

/// Sorts keys whose upper halves are codes, and whose lower halves grow. Digits take a quarter of
/// the time that comparisons take, as long as one thread has few keys.
void sort(std::vector<std::uint64_t>& keys) {
  constexpr std::size_t kFew = 512, kMany = 65'536;
  if (keys.size() < kFew || keys.size() > kMany)
    return tbb::parallel_sort(keys.begin(), keys.end());
  constexpr std::size_t kDigit = std::size_t{1} << kBits;
  std::vector<std::uint64_t> sorted(keys.size());
  for (int shift = 32; shift < 32 + 3 * kBits; shift += kBits) {
    const auto digit = [shift](std::uint64_t key) { return (key >> shift) % kDigit; };
    std::array<std::uint32_t, kDigit + 1> begin{};
    for (const std::uint64_t key : keys) ++begin[digit(key) + 1];
    for (std::size_t i = 1; i < kDigit; ++i) begin[i] += begin[i - 1];
    for (const std::uint64_t key : keys) sorted[begin[digit(key)]++] = key;
    keys.swap(sorted);
  }
}

/// Makes a column of equal numbers one of a single number.
template <class Column>
void make_single(Column& column, std::size_t size) {
  for (std::size_t i = 1; i < size; ++i) {
    if (!(column[i] == column[0])) return;
  }
  column.stride = 0;
}

}  // namespace

OrderedPoints::OrderedPoints(const accel::geometry::RayColumns& points) : columns(points) {
  const Extent extent(points);
  std::vector<std::uint64_t> keys(points.size);
  for (std::size_t i = 0; i < points.size; ++i) {
    std::uint64_t code = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
      code |= spread_bits(extent.part_of(points.origin[axis][i], axis)) << axis;
    keys[i] = code << 32 | i;
  }
  sort(keys);
  make_single(columns.tmax, points.size);
  make_single(columns.mask, points.size);
  order.resize(points.size);
  positions_.resize(3 * points.size);
  if (columns.tmax.stride != 0) tmax_.resize(points.size);
  if (columns.mask.stride != 0) masks_.resize(points.size);
  for (std::size_t i = 0; i < points.size; ++i) {
    const auto at = static_cast<std::uint32_t>(keys[i]);
    order[i] = at;
    for (std::size_t axis = 0; axis < 3; ++axis) positions_[3 * i + axis] = points.origin[axis][at];
    if (!tmax_.empty()) tmax_[i] = points.tmax[at];
    if (!masks_.empty()) masks_[i] = points.mask[at];
  }
  columns.origin = accel::geometry::columns_of_rows(positions_.data(), /*float64=*/true);
  columns.direction = {accel::geometry::for_all(kUnit), accel::geometry::for_all(kNone),
                       accel::geometry::for_all(kNone)};
  columns.tmin = accel::geometry::for_all(accel::geometry::kFromOrigin);
  if (!tmax_.empty()) columns.tmax = {tmax_.data(), 1, true};
  if (!masks_.empty()) columns.mask = {masks_.data(), 1};
}

}  // namespace sightline::scenegraph::query

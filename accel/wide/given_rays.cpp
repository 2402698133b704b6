// Reads columns of any layout into vectors.
#include "accel/wide/given_rays.h"

#include <algorithm>
#include <cstdint>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/wide/given_rays.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/wide/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

using geometry::RayColumns;
using geometry::RealColumn;

/// Which rays of a batch are read.
struct RayRange {
  std::size_t first, count;

  /// The ray of a lane; the last ray stands for lanes behind it.
  std::size_t ray(std::size_t lane) const { return first + std::min(lane, count - 1); }
};

template <class T>
const T* numbers(const std::byte* bytes) {
  return reinterpret_cast<const T*>(bytes);
}

template <class T>
bool is_aligned(const RealColumn& column) {
  return reinterpret_cast<std::uintptr_t>(column.data) % alignof(T) == 0;
}

/// Whether the first eight numbers of each ray are doubles side by side, as in an array of structs.
HWY_INLINE bool are_rows(const RayColumns& rays) {
  const RealColumn& x = rays.origin[0];
  const auto follows = [&](const RealColumn& column, std::size_t index) {
    return column.float64 && column.stride == x.stride &&
           column.data == static_cast<const std::byte*>(x.data) + index * sizeof(double);
  };
  return x.stride >= 8 && follows(x, 0) && follows(rays.origin[1], 1) &&
         follows(rays.origin[2], 2) && follows(rays.direction[0], 3) &&
         follows(rays.direction[1], 4) && follows(rays.direction[2], 5) && follows(rays.tmin, 6) &&
         follows(rays.tmax, 7) && is_aligned<double>(x);
}

/// The rows of the rays of a packet; the last ray stands for lanes behind it.
struct Rows {
  const double* first;
  std::size_t stride, last;

  const double* operator[](std::size_t lane) const { return first + std::min(lane, last) * stride; }
};

/// The rows of `kCount` lanes, as many as vectors have.
template <std::size_t kCount>
HWY_INLINE std::array<const double*, kCount> rows_of(const Rows& rows, std::size_t lane) {
  std::array<const double*, kCount> some;
  for (std::size_t i = 0; i < kCount; ++i) some[i] = rows[lane + i];
  return some;
}

// Transposes rows of numbers to columns, as wide as vectors are: a load that is wider than the
// stores before it would wait for them.
#if HWY_TARGET == HWY_SCALAR
template <class D>
HWY_INLINE void turn_rows(const D, const std::array<const double*, 1>& rows,
                          const std::array<double*, 8>& columns, std::size_t first) {
  for (std::size_t k = 0; k < 8; ++k) columns[k][first] = rows[0][k];
}
#else
template <class D>
HWY_INLINE void turn_rows(const D d, const std::array<const double*, 2>& rows,
                          const std::array<double*, 8>& columns, std::size_t first) {
  for (std::size_t k = 0; k < 8; k += 2) {
    const auto a = hn::LoadU(d, rows[0] + k), b = hn::LoadU(d, rows[1] + k);
    hn::Store(hn::InterleaveLower(d, a, b), d, columns[k] + first);
    hn::Store(hn::InterleaveUpper(d, a, b), d, columns[k + 1] + first);
  }
}

template <class D>
HWY_INLINE void turn_rows(const D d, const std::array<const double*, 4>& rows,
                          const std::array<double*, 8>& columns, std::size_t first) {
  for (std::size_t k = 0; k < 8; k += 4) {
    const auto a = hn::LoadU(d, rows[0] + k), b = hn::LoadU(d, rows[1] + k),
               c = hn::LoadU(d, rows[2] + k), e = hn::LoadU(d, rows[3] + k);
    const auto ab = hn::InterleaveLower(d, a, b), ab_odd = hn::InterleaveUpper(d, a, b),
               ce = hn::InterleaveLower(d, c, e), ce_odd = hn::InterleaveUpper(d, c, e);
    hn::Store(hn::ConcatLowerLower(d, ce, ab), d, columns[k] + first);
    hn::Store(hn::ConcatLowerLower(d, ce_odd, ab_odd), d, columns[k + 1] + first);
    hn::Store(hn::ConcatUpperUpper(d, ce, ab), d, columns[k + 2] + first);
    hn::Store(hn::ConcatUpperUpper(d, ce_odd, ab_odd), d, columns[k + 3] + first);
  }
}

template <class D>
HWY_INLINE void turn_rows(const D d, const std::array<const double*, 8>& rows,
                          const std::array<double*, 8>& columns, std::size_t first) {
  using V = hn::Vec<D>;
  // Each pair of rows, interleaved: the even columns, then the odd ones. A block has one column of
  // both rows.
  V pairs[2][4];
  // With this order, joining halves and then mixing blocks leaves the numbers in the order of the
  // rows.
  constexpr std::size_t kOrder[4] = {0, 4, 2, 6};
  for (std::size_t i = 0; i < 4; ++i) {
    const V a = hn::LoadU(d, rows[kOrder[i]]), b = hn::LoadU(d, rows[kOrder[i] + 1]);
    pairs[0][i] = hn::InterleaveLower(d, a, b);
    pairs[1][i] = hn::InterleaveUpper(d, a, b);
  }
  for (std::size_t odd = 0; odd < 2; ++odd) {
    const V* p = pairs[odd];
    const auto mix = [&](const V& x, const V& y, std::size_t k) {
      hn::Store(hn::OddEvenBlocks(hn::SwapAdjacentBlocks(y), x), d, columns[k + odd] + first);
      hn::Store(hn::OddEvenBlocks(y, hn::SwapAdjacentBlocks(x)), d, columns[k + 2 + odd] + first);
    };
    mix(hn::ConcatLowerLower(d, p[1], p[0]), hn::ConcatLowerLower(d, p[3], p[2]), 0);
    mix(hn::ConcatUpperUpper(d, p[1], p[0]), hn::ConcatUpperUpper(d, p[3], p[2]), 4);
  }
}
#endif

void read_rows(const Rows& rows, GivenRays& out) {
  const std::array<double*, 8> columns{out.origin[0].data(),    out.origin[1].data(),
                                       out.origin[2].data(),    out.direction[0].data(),
                                       out.direction[1].data(), out.direction[2].data(),
                                       out.tmin.data(),         out.tmax.data()};
  constexpr std::size_t kPer = Doubles::kPer;
  for (std::size_t lane = 0; lane < kLanes; lane += kPer)
    turn_rows(Doubles::D(), rows_of<kPer>(rows, lane), columns, lane);
}

using Floats = Lanes<float, kLanes>;
HWY_INLINE Doubles in_doubles(const Doubles& x) { return x; }
HWY_INLINE Doubles in_doubles(const Floats& x) { return to_doubles(x); }

/// Reads x, y, z, x, y, z and so on, for all lanes.
template <class T>
HWY_INLINE void read_interleaved(const T* from, std::array<Column<double>, 3>& out) {
  using Numbers = Lanes<T, kLanes>;
  Numbers axes[3];
  for (std::size_t i = 0; i < Numbers::kVectors; ++i)
    hn::LoadInterleaved3(typename Numbers::D(), from + 3 * i * Numbers::kPer, axes[0].v[i],
                         axes[1].v[i], axes[2].v[i]);
  for (std::size_t axis = 0; axis < 3; ++axis) in_doubles(axes[axis]).store(out[axis].data());
}

/// Reads a column of numbers T that are side by side; returns false if it is no such column.
template <class T>
HWY_INLINE bool read_packed(const RealColumn& column, const RayRange& range, Column<double>& out) {
  if (column.stride != 1 || range.count != kLanes || !is_aligned<T>(column)) return false;
  in_doubles(Lanes<T, kLanes>::load_unaligned(numbers<T>(column.at(range.first))))
      .store(out.data());
  return true;
}

HWY_INLINE void read_column(const RealColumn& column, const RayRange& range, Column<double>& out) {
  if (column.stride == 0) return Doubles::set(column[0]).store(out.data());
  if (column.float64 ? read_packed<double>(column, range, out)
                     : read_packed<float>(column, range, out))
    return;
  for (std::size_t lane = 0; lane < kLanes; ++lane) out[lane] = column[range.ray(lane)];
}

/// Whether the columns are those of rows of three numbers T.
template <class T>
HWY_INLINE bool are_interleaved(const std::array<RealColumn, 3>& columns) {
  const RealColumn& x = columns[0];
  if (!is_aligned<T>(x)) return false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const RealColumn& column = columns[axis];
    if (column.stride != 3 || column.float64 != x.float64 ||
        column.data != x.at(0) + axis * sizeof(T))
      return false;
  }
  return true;
}

HWY_INLINE void read_vectors(const std::array<RealColumn, 3>& columns, const RayRange& range,
                             std::array<Column<double>, 3>& out) {
  const RealColumn& x = columns[0];
  if (range.count == kLanes && x.stride == 3) {
    if (x.float64 && are_interleaved<double>(columns))
      return read_interleaved(numbers<double>(x.at(range.first)), out);
    if (!x.float64 && are_interleaved<float>(columns))
      return read_interleaved(numbers<float>(x.at(range.first)), out);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) read_column(columns[axis], range, out[axis]);
}

void read_rays(const RayColumns& rays, std::size_t first, std::size_t count, GivenRays& out) {
  const RayRange range{first, count};
  if (are_rows(rays)) {
    const RealColumn& x = rays.origin[0];
    return read_rows({numbers<double>(x.at(first)), x.stride, count - 1}, out);
  }
  read_vectors(rays.origin, range, out.origin);
  read_vectors(rays.direction, range, out.direction);
  read_column(rays.tmin, range, out.tmin);
  read_column(rays.tmax, range, out.tmax);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::wide {

HWY_EXPORT(read_rays);

void read(const geometry::RayColumns& rays, std::size_t first, std::size_t count, GivenRays& out) {
  HWY_DYNAMIC_DISPATCH(read_rays)(rays, first, count, out);
}

}  // namespace sightline::accel::wide
#endif  // HWY_ONCE

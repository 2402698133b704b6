// All arithmetic is as in geometry::set_local_ray, and not fused.
#include "accel/wide/carry.h"

#include <algorithm>
#include <cstddef>

#include "accel/geometry/local_ray.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/wide/carry.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/wide/vectors-inl.h"

#ifndef SIGHTLINE_WIDE_IDENTITY
#define SIGHTLINE_WIDE_IDENTITY
namespace sightline::accel::wide {
/// Its products and sums change no number but negative zeros, which set_rays() replaces as well.
inline constexpr Matrix kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
}  // namespace sightline::accel::wide
#endif

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

/// Zero where it is too small to count.
HWY_INLINE Doubles settled(const Doubles& x) {
  return Doubles::pick(abs(x) < Doubles::set(geometry::kSmallestRay), Doubles::set(0), x);
}

/// Not for NaN or infinity.
HWY_INLINE std::uint32_t are_finite(const Vectors& v) {
  const Doubles zero = Doubles::set(0);
  const Doubles nothing = v[0] * zero + v[1] * zero + v[2] * zero;
  return nothing <= zero;
}

/// The power of two that brings x into [1, 2), for x within 2^-1000 and 2^1001: those lanes are
/// returned.
HWY_INLINE std::uint32_t unit_of(const Doubles& x, Doubles& unit) {
  for (std::size_t i = 0; i < Doubles::kVectors; ++i) {
    const Doubles::D d;
    const hn::RebindToUnsigned<Doubles::D> bits;
    const auto exponent = hn::ShiftRight<52>(hn::BitCast(bits, x.v[i]));
    unit.v[i] = hn::BitCast(d, hn::ShiftLeft<52>(hn::Sub(hn::Set(bits, 2046), exponent)));
  }
  return (x >= Doubles::set(0x1p-1000)) & (x < Doubles::set(0x1p+1001));
}

HWY_INLINE std::uint32_t in_range(const Vectors& origin, const Vectors& direction, Doubles& unit) {
  return are_finite(origin) & are_finite(direction) & unit_of(max_norm(direction), unit) &
         (max_norm(origin) <= Doubles::set(geometry::kLargestRay));
}

HWY_INLINE Vectors relative(const Vectors& p, const geometry::Vec3d& center) {
  return {p[0] - Doubles::set(center.x), p[1] - Doubles::set(center.y),
          p[2] - Doubles::set(center.z)};
}

std::uint32_t valid_rays(const GivenRays& given, const geometry::Vec3d& center) {
  const Doubles tmin = Doubles::load(given.tmin.data()), tmax = Doubles::load(given.tmax.data());
  Doubles unit;
  return equal(tmin, tmin) & equal(tmax, tmax) &
         in_range(relative(load(given.origin), center), load(given.direction), unit);
}

/// The first eight numbers of a ray, which are consecutive.
const double* numbers(const geometry::Ray& ray) { return &ray.origin.x; }

/// The numbers of `count` rays from `first` on; the last ray stands for those behind it.
template <std::size_t kCount>
HWY_INLINE std::array<const double*, kCount> rows_of(std::span<const geometry::Ray> rays,
                                                     std::size_t first) {
  std::array<const double*, kCount> rows;
  for (std::size_t i = 0; i < kCount; ++i)
    rows[i] = numbers(rays[std::min(first + i, rays.size() - 1)]);
  return rows;
}

// Rows of numbers become columns. As wide as vectors are: a load that is wider than the stores
// before it would wait for them.
#if HWY_TARGET == HWY_SCALAR
HWY_INLINE void turn(std::span<const geometry::Ray> rays, std::array<double*, 8> columns) {
  for (std::size_t first = 0; first < kLanes; ++first) {
    const auto row = rows_of<1>(rays, first);
    for (std::size_t k = 0; k < 8; ++k) columns[k][first] = row[0][k];
  }
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
  // Of pairs of rows: the even columns, then the odd ones; two columns of a pair are a block.
  V pairs[2][4];
  // In this order, halves that are put together and then mixed by blocks are in the rows' order.
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

HWY_INLINE void turn(std::span<const geometry::Ray> rays, const std::array<double*, 8>& columns) {
  constexpr std::size_t kPer = Doubles::kPer;
  for (std::size_t first = 0; first < kLanes; first += kPer)
    turn_rows(Doubles::D(), rows_of<kPer>(rays, first), columns, first);
}
#endif

void read_rays(std::span<const geometry::Ray> rays, GivenRays& out) {
  turn(rays,
       {out.origin[0].data(), out.origin[1].data(), out.origin[2].data(), out.direction[0].data(),
        out.direction[1].data(), out.direction[2].data(), out.tmin.data(), out.tmax.data()});
}

HWY_INLINE std::uint32_t set_rays(const GivenRays& given, const Vectors& origin,
                                  const Vectors& direction, Rays& out) {
  Doubles unit;
  const std::uint32_t good = in_range(origin, direction, unit);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    settled(origin[axis]).store(out.origin[axis].data());
    settled(direction[axis] * unit).store(out.direction[axis].data());
  }
  unit.store(out.unit.data());
  Doubles::load(given.tmin.data()).store(out.tmin.data());
  Doubles::load(given.tmax.data()).store(out.tmax.data());
  return good;
}

std::uint32_t carry_rays(const GivenRays& given, const Matrix& m, Rays& out) {
  const Vectors p = load(given.origin), d = load(given.direction);
  if (m == kIdentity) return set_rays(given, p, d, out);
  const auto set = [&](std::size_t i) { return Doubles::set(m[i]); };
  const auto linear = [&](const Vectors& v, std::size_t row) {
    return set(4 * row) * v[0] + set(4 * row + 1) * v[1] + set(4 * row + 2) * v[2];
  };
  return set_rays(given, {linear(p, 0) + set(3), linear(p, 1) + set(7), linear(p, 2) + set(11)},
                  {linear(d, 0), linear(d, 1), linear(d, 2)}, out);
}

std::uint32_t center_rays(const GivenRays& given, const geometry::Vec3d& center, Rays& out) {
  return set_rays(given, relative(load(given.origin), center), load(given.direction), out);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::wide {

HWY_EXPORT(carry_rays);
HWY_EXPORT(center_rays);
HWY_EXPORT(read_rays);
HWY_EXPORT(valid_rays);

void read(std::span<const geometry::Ray> rays, GivenRays& out) {
  static_assert(offsetof(geometry::Ray, direction) == 3 * sizeof(double) &&
                offsetof(geometry::Ray, tmin) == 6 * sizeof(double) &&
                offsetof(geometry::Ray, tmax) == 7 * sizeof(double));
  HWY_DYNAMIC_DISPATCH(read_rays)(rays, out);
}

std::uint32_t valid(const GivenRays& given, const geometry::Vec3d& center, std::uint32_t lanes) {
  return lanes & HWY_DYNAMIC_DISPATCH(valid_rays)(given, center);
}

std::uint32_t carry(const GivenRays& given, const Matrix& matrix, std::uint32_t lanes, Rays& out) {
  return lanes & HWY_DYNAMIC_DISPATCH(carry_rays)(given, matrix, out);
}

std::uint32_t center(const GivenRays& given, const geometry::Vec3d& center, std::uint32_t lanes,
                     Rays& out) {
  return lanes & HWY_DYNAMIC_DISPATCH(center_rays)(given, center, out);
}

}  // namespace sightline::accel::wide
#endif  // HWY_ONCE

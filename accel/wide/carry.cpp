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

/// Turns rows of numbers, four of `count` rays from the first on, into columns.
HWY_INLINE void turn(std::span<const geometry::Ray> rays, std::size_t first, std::size_t number,
                     const std::array<double*, 8>& columns) {
  const auto row = [&](std::size_t i) {
    return numbers(rays[std::min(first + i, rays.size() - 1)]) + number;
  };
#if HWY_TARGET == HWY_SCALAR
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < 4; ++k) columns[number + k][first + i] = row(i)[k];
  }
#else
  using D = hn::CappedTag<double, 4>;
  const D d;
  if constexpr (hn::MaxLanes(D()) == 4) {
    const auto a = hn::LoadU(d, row(0)), b = hn::LoadU(d, row(1)), c = hn::LoadU(d, row(2)),
               e = hn::LoadU(d, row(3));
    const auto ab_even = hn::InterleaveLower(d, a, b), ab_odd = hn::InterleaveUpper(d, a, b),
               ce_even = hn::InterleaveLower(d, c, e), ce_odd = hn::InterleaveUpper(d, c, e);
    hn::StoreU(hn::ConcatLowerLower(d, ce_even, ab_even), d, columns[number] + first);
    hn::StoreU(hn::ConcatLowerLower(d, ce_odd, ab_odd), d, columns[number + 1] + first);
    hn::StoreU(hn::ConcatUpperUpper(d, ce_even, ab_even), d, columns[number + 2] + first);
    hn::StoreU(hn::ConcatUpperUpper(d, ce_odd, ab_odd), d, columns[number + 3] + first);
  } else {
    for (std::size_t i = 0; i < 4; i += 2) {
      for (std::size_t k = 0; k < 4; k += 2) {
        const auto a = hn::LoadU(d, row(i) + k), b = hn::LoadU(d, row(i + 1) + k);
        hn::StoreU(hn::InterleaveLower(d, a, b), d, columns[number + k] + first + i);
        hn::StoreU(hn::InterleaveUpper(d, a, b), d, columns[number + k + 1] + first + i);
      }
    }
  }
#endif
}

void read_rays(std::span<const geometry::Ray> rays, GivenRays& out) {
  const std::array<double*, 8> columns{out.origin[0].data(),    out.origin[1].data(),
                                       out.origin[2].data(),    out.direction[0].data(),
                                       out.direction[1].data(), out.direction[2].data(),
                                       out.tmin.data(),         out.tmax.data()};
  for (std::size_t first = 0; first < kLanes; first += 4) {
    turn(rays, first, 0, columns);
    turn(rays, first, 4, columns);
  }
}

HWY_INLINE std::uint32_t set_rays(const Vectors& origin, const Vectors& direction, Rays& out) {
  Doubles unit;
  const std::uint32_t good = in_range(origin, direction, unit);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    settled(origin[axis]).store(out.origin[axis].data());
    settled(direction[axis] * unit).store(out.direction[axis].data());
  }
  unit.store(out.unit.data());
  return good;
}

std::uint32_t carry_rays(const GivenRays& given, const Matrix& m, Rays& out) {
  const Vectors p = load(given.origin), d = load(given.direction);
  const auto set = [&](std::size_t i) { return Doubles::set(m[i]); };
  const auto linear = [&](const Vectors& v, std::size_t row) {
    return set(4 * row) * v[0] + set(4 * row + 1) * v[1] + set(4 * row + 2) * v[2];
  };
  return set_rays({linear(p, 0) + set(3), linear(p, 1) + set(7), linear(p, 2) + set(11)},
                  {linear(d, 0), linear(d, 1), linear(d, 2)}, out);
}

std::uint32_t center_rays(const GivenRays& given, const geometry::Vec3d& center, Rays& out) {
  return set_rays(relative(load(given.origin), center), load(given.direction), out);
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

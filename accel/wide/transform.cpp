// All arithmetic is as in geometry::set_local_ray, and not fused.
#include "accel/wide/transform.h"

#include <array>
#include <cstddef>
#include <tuple>

#include "accel/geometry/local_ray.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/wide/transform.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/wide/vectors-inl.h"

#ifndef SIGHTLINE_WIDE_IDENTITY
#define SIGHTLINE_WIDE_IDENTITY
namespace sightline::accel::wide {
/// The identity. Its products and sums change no number but negative zeros, which set_rays()
/// replaces as well.
inline constexpr Matrix kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
}  // namespace sightline::accel::wide
#endif

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

/// Replaces numbers that are too small to count by zero.
HWY_INLINE Doubles flushed(const Doubles& x) {
  return Doubles::pick(abs(x) < Doubles::set(geometry::kSmallestRay), Doubles::set(0), x);
}

/// The rays without NaN and infinity.
HWY_INLINE std::uint32_t are_finite(const Vectors& v) {
  const Doubles zero = Doubles::set(0);
  const Doubles nothing = v[0] * zero + v[1] * zero + v[2] * zero;
  return nothing <= zero;
}

/// Sets `unit` to the power of two that brings x into [1, 2). Returns the lanes in which x is at
/// least 2^-1000 and less than 2^1001; only there `unit` is valid.
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

HWY_INLINE std::uint32_t set_rays(const GivenRays& given, const Vectors& origin,
                                  const Vectors& direction, Rays& out) {
  Doubles unit;
  const std::uint32_t good = in_range(origin, direction, unit);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    flushed(origin[axis]).store(out.origin[axis].data());
    flushed(direction[axis] * unit).store(out.direction[axis].data());
  }
  unit.store(out.unit.data());
  Doubles::load(given.tmin.data()).store(out.tmin.data());
  Doubles::load(given.tmax.data()).store(out.tmax.data());
  return good;
}

/// entry(i) is the entry i of a matrix, in all lanes or in each lane that of its own.
template <class Entry>
HWY_INLINE std::uint32_t transform_by(const GivenRays& given, const Entry& entry, Rays& out) {
  const Vectors p = load(given.origin), d = load(given.direction);
  const auto linear = [&](const Vectors& v, std::size_t row) {
    return entry(4 * row) * v[0] + entry(4 * row + 1) * v[1] + entry(4 * row + 2) * v[2];
  };
  return set_rays(given,
                  {linear(p, 0) + entry(3), linear(p, 1) + entry(7), linear(p, 2) + entry(11)},
                  {linear(d, 0), linear(d, 1), linear(d, 2)}, out);
}

std::uint32_t transform_rays(const GivenRays& given, const Matrix& m, Rays& out) {
  if (m == kIdentity) return set_rays(given, load(given.origin), load(given.direction), out);
  return transform_by(
      given, [&](std::size_t i) { return Doubles::set(m[i]); }, out);
}

std::uint32_t transform_rays_each(const GivenRays& given, const Column<const Matrix*>& matrices,
                                  Rays& out) {
  std::array<Column<double>, std::tuple_size_v<Matrix>> columns;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    for (std::size_t i = 0; i < columns.size(); ++i) columns[i][lane] = (*matrices[lane])[i];
  }
  return transform_by(
      given, [&](std::size_t i) { return Doubles::load(columns[i].data()); }, out);
}

std::uint32_t center_rays(const GivenRays& given, const geometry::Vec3d& center, Rays& out) {
  return set_rays(given, relative(load(given.origin), center), load(given.direction), out);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::wide {

HWY_EXPORT(transform_rays);
HWY_EXPORT(transform_rays_each);
HWY_EXPORT(center_rays);
HWY_EXPORT(valid_rays);

std::uint32_t valid(const GivenRays& given, const geometry::Vec3d& center, std::uint32_t lanes) {
  return lanes & HWY_DYNAMIC_DISPATCH(valid_rays)(given, center);
}

std::uint32_t transform(const GivenRays& given, const Matrix& matrix, std::uint32_t lanes,
                        Rays& out) {
  return lanes & HWY_DYNAMIC_DISPATCH(transform_rays)(given, matrix, out);
}

std::uint32_t transform(const GivenRays& given, const Column<const Matrix*>& matrices,
                        std::uint32_t lanes, Rays& out) {
  return lanes & HWY_DYNAMIC_DISPATCH(transform_rays_each)(given, matrices, out);
}

std::uint32_t center(const GivenRays& given, const geometry::Vec3d& center, std::uint32_t lanes,
                     Rays& out) {
  return lanes & HWY_DYNAMIC_DISPATCH(center_rays)(given, center, out);
}

}  // namespace sightline::accel::wide
#endif  // HWY_ONCE

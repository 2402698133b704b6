// All arithmetic is as in geometry::set_local_ray, and not fused.
#include "accel/wide/carry.h"

#include "accel/geometry/local_ray.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/wide/carry.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/wide/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

using Doubles = Lanes<double, kLanes>;
using Vectors = std::array<Doubles, 3>;

HWY_INLINE Vectors load(const std::array<Column<double>, 3>& columns) {
  return {Doubles::load(columns[0].data()), Doubles::load(columns[1].data()),
          Doubles::load(columns[2].data())};
}

HWY_INLINE Doubles largest(const Vectors& v) { return max(max(abs(v[0]), abs(v[1])), abs(v[2])); }

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
  std::uint32_t good = 0;
  for (std::size_t i = 0; i < Doubles::kVectors; ++i) {
    const Doubles::D d;
    const hn::RebindToUnsigned<Doubles::D> bits;
    const auto exponent = hn::ShiftRight<52>(hn::BitCast(bits, x.v[i]));
    unit.v[i] = hn::BitCast(d, hn::ShiftLeft<52>(hn::Sub(hn::Set(bits, 2046), exponent)));
  }
  good = (x >= Doubles::set(0x1p-1000)) & (x < Doubles::set(0x1p+1001));
  return good;
}

HWY_INLINE std::uint32_t set_rays(const Vectors& origin, const Vectors& direction, Rays& out) {
  const Doubles most = largest(direction);
  Doubles unit;
  const std::uint32_t good =
      are_finite(origin) & are_finite(direction) & unit_of(most, unit) &
      (largest(origin) <= Doubles::set(geometry::kLargestRay));
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
  const Vectors p = load(given.origin);
  return set_rays({p[0] - Doubles::set(center.x), p[1] - Doubles::set(center.y),
                   p[2] - Doubles::set(center.z)},
                  load(given.direction), out);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::wide {

HWY_EXPORT(carry_rays);
HWY_EXPORT(center_rays);

std::uint32_t carry(const GivenRays& given, const Matrix& matrix, std::uint32_t lanes, Rays& out) {
  return lanes & HWY_DYNAMIC_DISPATCH(carry_rays)(given, matrix, out);
}

std::uint32_t center(const GivenRays& given, const geometry::Vec3d& center, std::uint32_t lanes,
                     Rays& out) {
  return lanes & HWY_DYNAMIC_DISPATCH(center_rays)(given, center, out);
}

}  // namespace sightline::accel::wide
#endif  // HWY_ONCE

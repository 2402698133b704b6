// The slab test, in floats, with a bound on its error.
#include "accel/kdtree/box_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/kdtree/box_filter.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::kdtree {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

std::uint64_t may_meet_mask(const FilterRay&, std::span<const Reference>) {
  return ~std::uint64_t{0};
}

#else

/// The lower (kUpper: the upper) corners of as many boxes as D has blocks of four lanes.
template <bool kUpper, class D>
HWY_INLINE hn::Vec<D> load_corners(D d, const Reference* refs) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    return hn::LoadU(d, kUpper ? &refs->hi.x : &refs->lo.x);
  } else {
    const hn::Half<D> half;
    return hn::Combine(d, load_corners<kUpper>(half, refs + hn::MaxLanes(half) / 4),
                       load_corners<kUpper>(half, refs));
  }
}

/// Tests a few boxes at a time, each in a block of four lanes.
///
/// The error bound, with u = 2^-24: a plane's t is off by three roundings of itself, and by what
/// FilterRay::near and far hold for the rounded origin. Widening rounds t twice more. 8 u is above
/// the sum. Where numbers are too large, the interval is infinite or NaN, and no box is rejected.
template <class D>
class Boxes {
 public:
  using V = hn::Vec<D>;
  static constexpr std::size_t kBoxes = hn::MaxLanes(D()) / 4;

  explicit Boxes(const FilterRay& ray)
      : origin_(hn::LoadDup128(D(), ray.origin.data())),
        inverse_(hn::LoadDup128(D(), ray.inverse.data())),
        near_(hn::LoadDup128(D(), ray.near.data())),
        far_(hn::LoadDup128(D(), ray.far.data())) {}

  /// Bit i is set unless box i is certainly not met.
  HWY_INLINE std::uint64_t may_meet(const Reference* refs) const {
    const D d;
    alignas(16) static constexpr std::uint32_t kCoordinates[4] = {~0u, ~0u, ~0u, 0};
    const hn::RebindToUnsigned<D> du;
    const V keep = hn::BitCast(d, hn::LoadDup128(du, kCoordinates));
    const V lower = hn::And(keep, load_corners<false>(d, refs)),
            upper = hn::And(keep, load_corners<true>(d, refs));
    const auto down = hn::Lt(inverse_, hn::Zero(d));
    const V first = plane(hn::IfThenElse(down, upper, lower)),
            last = plane(hn::IfThenElse(down, lower, upper));
    const V u8 = hn::Set(d, 0x1p-21f);
    V t_in = hn::Sub(first, hn::MulAdd(hn::Abs(first), u8, near_));
    V t_out = hn::Add(last, hn::MulAdd(hn::Abs(last), u8, far_));
    t_in = hn::Max(t_in, hn::Shuffle2301(t_in));
    t_out = hn::Min(t_out, hn::Shuffle2301(t_out));
    t_in = hn::Max(t_in, hn::Shuffle1032(t_in));
    t_out = hn::Min(t_out, hn::Shuffle1032(t_out));
    const auto met = hn::Not(hn::Gt(t_in, t_out));
    if (hn::AllFalse(d, met)) return 0;
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, met, bits);
    const unsigned lanes = bits[0] | static_cast<unsigned>(bits[1]) << 8;
    std::uint64_t boxes = 0;
    for (std::size_t i = 0; i < kBoxes; ++i) boxes |= std::uint64_t{lanes >> 4 * i & 1} << i;
    return boxes;
  }

 private:
  HWY_INLINE V plane(V at) const { return hn::Mul(hn::Sub(at, origin_), inverse_); }

  V origin_, inverse_, near_, far_;
};

std::uint64_t may_meet_mask(const FilterRay& ray, std::span<const Reference> refs) {
  const Boxes<hn::CappedTag<float, 16>> several(ray);
  const Boxes<hn::FixedTag<float, 4>> one(ray);
  constexpr std::size_t kBoxes = Boxes<hn::CappedTag<float, 16>>::kBoxes;
  std::uint64_t met = 0;
  std::size_t i = 0;
  for (; i + kBoxes <= refs.size(); i += kBoxes) met |= several.may_meet(refs.data() + i) << i;
  for (; i < refs.size(); ++i) met |= one.may_meet(refs.data() + i) << i;
  return met;
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::kdtree
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::kdtree {

HWY_EXPORT(may_meet_mask);

namespace {

constexpr auto kMost = static_cast<double>(std::numeric_limits<float>::max());

/// A float that is not less.
float round_up(double x) {
  if (!(x < kMost / 2)) return std::numeric_limits<float>::infinity();
  constexpr double kRelative = 0x1p-22;
  constexpr double kTiny = 0x1p-100;
  return static_cast<float>(std::max(x, -kMost / 2) + std::fabs(x) * kRelative + kTiny);
}

}  // namespace

FilterRay filter_ray(const TreeRay& ray) {
  // A ray that is steeper against an axis than this is turned to it, so that its planes have a
  // finite t.
  constexpr double kSteepest = 0x1p+60;
  const double farthest = std::max(std::fabs(ray.t_in), std::fabs(ray.t_out));
  FilterRay out;
  for (std::size_t a = 0; a < 3; ++a) {
    const double inverse = std::clamp(ray.inverse[a], -kSteepest, kSteepest);
    const double at = std::clamp(ray.local->origin[a], -kMost, kMost);
    out.origin[a] = static_cast<float>(at);
    out.inverse[a] = static_cast<float>(inverse);
    const double rounded = std::fabs(ray.local->origin[a] - static_cast<double>(out.origin[a]));
    constexpr double kMargin = 1.01;  // for the roundings of the margin itself
    const double off = (rounded + farthest / kSteepest) * std::fabs(inverse) + ray.slack;
    out.near[a] = out.far[a] = round_up(kMargin * off);
  }
  out.inverse[3] = 1;
  out.near[3] = round_up(-ray.t_in);
  out.far[3] = round_up(ray.t_out);
  return out;
}

void end_at(FilterRay& ray, double limit) { ray.far[3] = std::min(ray.far[3], round_up(limit)); }

std::uint64_t may_meet_mask(const FilterRay& ray, std::span<const Reference> refs) {
  const std::uint64_t met = HWY_DYNAMIC_DISPATCH(may_meet_mask)(ray, refs);
  return met & (~std::uint64_t{0} >> (kFilterBatch - refs.size()));
}

}  // namespace sightline::accel::kdtree
#endif  // HWY_ONCE

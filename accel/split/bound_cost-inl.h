// The cost of several splits at once, from counts in registers. Compiled once per SIMD target.
#if defined(SIGHTLINE_BOUND_COST_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_BOUND_COST_INL
#undef SIGHTLINE_BOUND_COST_INL
#else
#define SIGHTLINE_BOUND_COST_INL
#endif

#include <hwy/highway.h>

#include "accel/split/cost_model.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::split {
namespace HWY_NAMESPACE {

/// Terms of the cost of a split along one axis, relative to SA(cell): SA_L(x) = ends + slope (x -
/// lo), SA_R(x) = ends + slope (hi - x).
struct BoundCosts {
  BoundCosts(const geometry::Aabb& cell, std::size_t axis, double per_whole, double empty_bonus)
      : lo(cell.lo[axis]), hi(cell.hi[axis]), bonus(static_cast<float>(empty_bonus)) {
    const SplitAreas areas(cell, static_cast<int>(axis), per_whole);
    ends = static_cast<float>(areas.ends() * per_whole);
    slope = static_cast<float>(areas.slope() * per_whole);
  }

  /// Cost of the children for splits at x with these weights on the sides. Uses no fused
  /// multiply-add, so that every target gets the same bits.
  template <class D, class V = hwy::HWY_NAMESPACE::Vec<D>>
  V children(D d, V x, V left, V right) const {
    namespace hn = hwy::HWY_NAMESPACE;
    const V at = hn::Set(d, ends), per = hn::Set(d, slope);
    const V below = hn::Add(at, hn::Mul(per, hn::Sub(x, hn::Set(d, lo))));
    const V above = hn::Add(at, hn::Mul(per, hn::Sub(hn::Set(d, hi), x)));
    const V sum = hn::Add(hn::Mul(below, left), hn::Mul(above, right));
    const auto one_empty = hn::Eq(hn::Min(left, right), hn::Zero(d));
    return hn::IfThenElse(one_empty, hn::Mul(sum, hn::Set(d, bonus)), sum);
  }

  float lo, hi, ends, slope, bonus;
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::split
HWY_AFTER_NAMESPACE();

#endif  // toggle

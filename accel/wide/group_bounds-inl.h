// What a group of rays can meet: bounds over all of its rays, for boxes and for triangles.
#if defined(SIGHTLINE_WIDE_GROUP_BOUNDS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_WIDE_GROUP_BOUNDS_INL
#undef SIGHTLINE_WIDE_GROUP_BOUNDS_INL
#else
#define SIGHTLINE_WIDE_GROUP_BOUNDS_INL
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "accel/wide/float_rays.h"
#include "accel/wide/single-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

/// The least and the greatest of a number over a group of rays.
struct Range {
  float lo, hi;
};

HWY_INLINE Range range_of(const Column<float>& column, std::uint32_t group) {
  const Floats all = Floats::load(column.data());
  const float infinity = std::numeric_limits<float>::infinity();
  return {Floats::pick(group, all, Floats::set(infinity)).least(),
          Floats::pick(group, all, Floats::set(-infinity)).greatest()};
}

HWY_INLINE float largest(const Range& range) {
  return std::max(std::fabs(range.lo), std::fabs(range.hi));
}

/// A box test for all rays of a group at once: bounds of the planes' t.
class GroupBoxes {
 public:
  HWY_INLINE GroupBoxes(const Packet& packet, std::uint32_t group, float extent) {
    const FloatRays& rays = packet.floats;
    const std::uint32_t key = rays.key[static_cast<std::size_t>(std::countr_zero(group))];
    std::array<Range, 3> origins;
    float farthest = extent;
    const float off = range_of(rays.off, group).hi;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      origins[axis] = range_of(rays.origin[axis], group);
      farthest = std::max(farthest, extent + largest(origins[axis]));
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Range origin = origins[axis], inverse = range_of(rays.inverse[axis], group);
      const float error =
          (2 * largest(origin) + extent) * kPlaneError + farthest * kSteepError + kTiny + off;
      backward_[axis] = (key >> axis & 1) != 0;
      row_[axis] = 2 * axis + (key >> axis & 1);
      lo_[axis] = Boxes::set(origin.lo - error);
      hi_[axis] = Boxes::set(origin.hi + error);
      least_[axis] = Boxes::set(inverse.lo);
      greatest_[axis] = Boxes::set(inverse.hi);
    }
    t_in_ = Boxes::set(range_of(rays.t_in, group).lo);
  }

  /// Returns the children that a ray may meet before t_out; sets where the first one may enter.
  HWY_INLINE std::uint32_t met(const kdtree::WideNode& node, float t_out, Boxes& in) const {
    in = max(max(near(node, 0), near(node, 1)), max(near(node, 2), t_in_));
    const Boxes out = min(min(far(node, 0), far(node, 1)), min(far(node, 2), Boxes::set(t_out)));
    return in <= out;
  }

 private:
  HWY_INLINE Boxes near(const kdtree::WideNode& node, std::size_t axis) const {
    const Boxes x =
        Boxes::load(node.bounds[row_[axis]].data()) - (backward_[axis] ? lo_[axis] : hi_[axis]);
    return min(x * least_[axis], x * greatest_[axis]);
  }
  HWY_INLINE Boxes far(const kdtree::WideNode& node, std::size_t axis) const {
    const Boxes x =
        Boxes::load(node.bounds[row_[axis] ^ 1].data()) - (backward_[axis] ? hi_[axis] : lo_[axis]);
    return max(x * least_[axis], x * greatest_[axis]);
  }

  std::array<Boxes, 3> lo_, hi_, least_, greatest_;
  Boxes t_in_;
  std::array<std::size_t, 3> row_;
  std::array<bool, 3> backward_;
};

/// Finds the triangles of a block that no ray of a group can meet: seen from all of them, they lie
/// to one side.
class GroupView {
 public:
  HWY_INLINE GroupView(const Packet& packet, std::uint32_t group) {
    const FloatRays& rays = packet.floats;
    const Range x = range_of(rays.x, group), y = range_of(rays.y, group),
                z = range_of(rays.z, group), shear_x = range_of(rays.shear_x, group),
                shear_y = range_of(rays.shear_y, group), error = range_of(rays.error, group);
    x_ = {Floats::set(x.lo), Floats::set(x.hi)};
    y_ = {Floats::set(y.lo), Floats::set(y.hi)};
    z_ = {Floats::set(z.lo), Floats::set(z.hi)};
    shear_x_ = {Floats::set(shear_x.lo), Floats::set(shear_x.hi)};
    shear_y_ = {Floats::set(shear_y.lo), Floats::set(shear_y.hi)};
    error_ = Floats::set(8 * error.hi);
    sign_ = Floats::set(rays.sign[static_cast<std::size_t>(std::countr_zero(group))]);
  }

  /// A bit for each triangle that some ray may meet. The axes are those of FloatRays::x, y and z.
  HWY_INLINE std::uint32_t possible(const blocks::Block& block, const float* x, const float* y,
                                    const float* z) const {
    const Floats depth = Floats::load_unaligned(z) * sign_;
    const Interval seen_z{depth - z_.hi, depth - z_.lo};
    const Interval seen_x = seen(Floats::load_unaligned(x), x_, shear_x_, seen_z),
                   seen_y = seen(Floats::load_unaligned(y), y_, shear_y_, seen_z);
    const Floats largest = max(max(size(seen_x), size(seen_y)), Floats::set(2) * size(seen_z));
    const Floats error = mul_add(largest, Floats::set(0x1p-19f), error_);
    const Floats zero = Floats::set(0);
    const std::uint32_t beside = to_one_side(block, widened(seen_x, error), zero) |
                                 to_one_side(block, widened(seen_y, error), zero);
    return ((2u << (block.triangles - 1)) - 1) & ~beside;
  }

 private:
  struct Interval {
    Floats lo, hi;
  };
  static HWY_INLINE Floats size(const Interval& i) { return max(abs(i.lo), abs(i.hi)); }
  static HWY_INLINE Interval widened(const Interval& i, const Floats& by) {
    return {i.lo - by, i.hi + by};
  }
  /// v minus the origin minus shear times depth.
  static HWY_INLINE Interval seen(const Floats& v, const Interval& origin, const Interval& shear,
                                  const Interval& depth) {
    const Floats a = shear.lo * depth.lo, b = shear.lo * depth.hi, c = shear.hi * depth.lo,
                 d = shear.hi * depth.hi;
    return {v - origin.hi - max(max(a, b), max(c, d)), v - origin.lo - min(min(a, b), min(c, d))};
  }
  static HWY_INLINE std::uint32_t to_one_side(const blocks::Block& block, const Interval& seen,
                                              const Floats& zero) {
    alignas(64) std::array<float, 16> lo, hi;
    if constexpr (Floats::kVectors > 1) {
      seen.lo.store(lo.data());
      seen.hi.store(hi.data());
    }
    const Gather a(block.corner(0)), b(block.corner(1)), c(block.corner(2));
    const Floats least_lo =
        least(a(seen.lo, lo.data()), b(seen.lo, lo.data()), c(seen.lo, lo.data()));
    const Floats most_hi =
        most(a(seen.hi, hi.data()), b(seen.hi, hi.data()), c(seen.hi, hi.data()));
    return (least_lo > zero) | (most_hi < zero);
  }

  Interval x_, y_, z_, shear_x_, shear_y_;
  Floats error_, sign_;
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#endif  // toggle

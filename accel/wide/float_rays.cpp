// Prepares rays for float tests. docs/hit_rule.md, section 7, derives every constant.
#include "accel/wide/float_rays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "accel/geometry/intersect.h"
#include "accel/wide/float_points.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/wide/float_rays.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/wide/lanes-inl.h"

#ifndef SIGHTLINE_WIDE_LARGEST_T
#define SIGHTLINE_WIDE_LARGEST_T
namespace sightline::accel::wide {
/// Greater than any t at which a ray meets a tree, counted from the origin that floats have.
constexpr double kLargestT = 0x1p+100;
}  // namespace sightline::accel::wide
#endif

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

using Doubles = Lanes<double, kLanes>;
using Floats = Lanes<float, kLanes>;

/// Float tests of a ray that begins this far away could overflow, so its origin is moved along it
/// to the tree.
constexpr double kFar = 0x1p+61;
/// A moved origin is off by at most this share of the distance.
constexpr double kShiftError = 0x1p-50;
/// Floats know nothing of a ray whose moved origin is off by more than kMostOff. It counts as off
/// by kBlindOff, which is far more than any size, so that nothing is certain.
constexpr double kMostOff = 0x1p+58, kBlindOff = 0x1p+64;
/// The rays whose main axis, that of the direction's largest component, is y, and z.
struct MainAxis {
  std::uint32_t y, z;

  template <class Numbers>
  HWY_INLINE explicit MainAxis(const std::array<Numbers, 3>& direction) {
    const Numbers along_x = abs(direction[0]), along_y = abs(direction[1]),
                  along_z = abs(direction[2]);
    z = along_z > max(along_x, along_y);
    y = (along_y > along_x) & ~z;
  }

  /// v[first], v[first + 1] or v[first + 2], cyclically, for main axis x, y or z.
  template <class Numbers>
  HWY_INLINE Numbers pick(const std::array<Numbers, 3>& v, std::size_t first) const {
    return Numbers::pick(z, v[(first + 2) % 3], Numbers::pick(y, v[(first + 1) % 3], v[first]));
  }
};

HWY_INLINE Floats widened_down(const Floats& t, float by) {
  return neg_mul_add(abs(t), Floats::set(by), t);
}
HWY_INLINE Floats widened_up(const Floats& t, float by) {
  return mul_add(abs(t), Floats::set(by), t);
}

class Preparing {
 public:
  HWY_INLINE Preparing(Packet& packet, const Frame& frame)
      : packet_(packet), frame_(frame), out_(packet.floats) {}

  HWY_INLINE std::uint32_t prepare(std::uint32_t lanes) {
    for (std::size_t axis = 0; axis < 3; ++axis) set_from(axis);
    far_ = lanes & (frame_.is_boundless ? Doubles::kAll : far_);
    packet_.extent = largest_coordinate(frame_.bounds);
    if (far_ != 0) shift();
    if (frame_.error > 0) off_ = off_ + Floats::set(frame_.error);
    shift_.store(out_.shift.data());
    off_.store(out_.off.data());
    for (std::size_t axis = 0; axis < 3; ++axis) set_origin(axis);
    for (std::size_t axis = 0; axis < 3; ++axis) set_planes(axis);
    set_main_axis();
    if (far_ != 0) set_far_distance();
    const std::uint32_t meet = set_limits();
    packet_.center = frame_.center;
    packet_.scale = static_cast<double>(frame_.scale);
    packet_.candidates.has_best = 0;
    packet_.candidates.count.fill(0);
    packet_.live = lanes & meet & ~beside_;
    return packet_.live;
  }

 private:
  HWY_INLINE void set_from(std::size_t axis) {
    from_[axis] = Doubles::load(packet_.rays.origin[axis].data()) -
                  Doubles::set(static_cast<double>(frame_.center[axis]));
    if (frame_.scale != 1)
      from_[axis] = from_[axis] * Doubles::set(static_cast<double>(frame_.scale));
    far_ |= abs(from_[axis]) > Doubles::set(kFar);
  }

  /// Moves the origins of far rays along them to the plane through the center that is across their
  /// largest component. A ray that is then still far away does not meet the tree.
  HWY_INLINE void shift() {
    std::array<Doubles, 3> direction;
    for (std::size_t axis = 0; axis < 3; ++axis)
      direction[axis] = Doubles::load(packet_.rays.direction[axis].data());
    const MainAxis main(direction);
    const Doubles zero = Doubles::set(0);
    shift_ = Doubles::pick(far_, neg(main.pick(from_, 0) / main.pick(direction, 0)), zero);
    const Doubles most = max(max(abs(from_[0]), abs(from_[1])), abs(from_[2]));
    const Doubles off = most * Doubles::set(kShiftError);
    blind_ = frame_.is_boundless ? far_ : far_ & (off > Doubles::set(kMostOff));
    const Doubles least_beside = Doubles::set(kFar) + (off + off);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Doubles moved = mul_add(shift_, direction[axis], from_[axis]);
      beside_ |= far_ & ~blind_ & (abs(moved) > least_beside);
      from_[axis] = Doubles::pick(blind_ | beside_, zero, Doubles::pick(far_, moved, from_[axis]));
    }
    const Doubles known = Doubles::pick(blind_, Doubles::set(kBlindOff), off);
    off_ = to_floats(Doubles::pick(far_, known, zero));
    far_distance_ = to_floats(Doubles::pick(blind_, zero, most)) + Floats::set(packet_.extent);
  }

  /// Sets the distances of hits from where far rays begin. No limit is known for blind ones.
  HWY_INLINE void set_far_distance() {
    const Floats unknown = Floats::set(std::numeric_limits<float>::infinity());
    distance_ = Floats::pick(far_, Floats::pick(blind_, unknown, far_distance_), distance_);
    t_in_ = Floats::pick(blind_, neg(unknown), t_in_);
    t_out_ = Floats::pick(blind_, unknown, t_out_);
  }

  HWY_INLINE void set_origin(std::size_t axis) {
    const Floats o = to_floats(from_[axis]), size = abs(o), reach = reach_from(o, axis);
    o.store(out_.origin[axis].data());
    origin_[axis] = o;
    most_origin_ = axis == 0 ? size : max(most_origin_, size);
    distance_ = axis == 0 ? reach : max(distance_, reach);
  }

  /// The distance from an origin to the farther bound.
  HWY_INLINE Floats reach_from(const Floats& origin, std::size_t axis) const {
    return max(abs(Floats::set(frame_.bounds.lo[axis]) - origin),
               abs(Floats::set(frame_.bounds.hi[axis]) - origin));
  }

  HWY_INLINE void set_planes(std::size_t axis) {
    const Doubles along = Doubles::load(packet_.rays.direction[axis].data());
    // A component that is zero in float keeps the sign of the double.
    const std::uint32_t negative = Doubles::bits([&](std::size_t i) {
      const Doubles::D d;
      return hn::Lt(hn::CopySign(hn::Set(d, 1.0), along.v[i]), hn::Zero(d));
    });
    const Floats d = to_floats(along), o = origin_[axis];
    const Floats least = Floats::set(kLeastDirection);
    const Floats bounded = Floats::pick(
        abs(d) < least, Floats::pick(negative, Floats::set(-kLeastDirection), least), d);
    const Floats inverse = Floats::set(1) / bounded;
    const Floats steep = mul_add(distance_, Floats::set(kSteepError), Floats::set(kTiny)) + off_;
    const Floats error =
        abs(inverse) * mul_add(abs(o) + reach_from(o, axis), Floats::set(kPlaneError), steep);
    const Floats at_origin = o * inverse, zero = Floats::set(0);
    direction_[axis] = d;
    octant_[axis] = negative;
    inverse.store(out_.inverse[axis].data());
    (zero - at_origin - error).store(out_.near[axis].data());
    (error - at_origin).store(out_.far[axis].data());
    const Floats lo = Floats::set(frame_.bounds.lo[axis]) - o,
                 hi = Floats::set(frame_.bounds.hi[axis]) - o;
    const Floats near = mul_sub(Floats::pick(negative, hi, lo), inverse, error),
                 far = mul_add(Floats::pick(negative, lo, hi), inverse, error);
    t_in_ = axis == 0 ? near : max(t_in_, near);
    t_out_ = axis == 0 ? far : min(t_out_, far);
  }

  HWY_INLINE void set_main_axis() {
    const MainAxis main(direction_);
    using Keys = Lanes<std::uint32_t, kLanes>;
    const auto bit = [](std::uint32_t lanes, std::uint32_t value) {
      return Keys::pick(lanes, Keys::set(value), Keys::set(0));
    };
    (bit(octant_[0], 1) + bit(octant_[1], 2) + bit(octant_[2], 4) + bit(main.y, 8) +
     bit(main.z, 16))
        .store(out_.key.data());
    const Floats along = main.pick(direction_, 0), one = Floats::set(1);
    depth_ = abs(along);
    backward_ = along < Floats::set(0);
    const Floats sign = Floats::pick(backward_, Floats::set(-1), one), per = one / depth_;
    sign.store(out_.sign.data());
    (main.pick(origin_, 0) * sign).store(out_.z.data());
    main.pick(origin_, 1).store(out_.x.data());
    main.pick(origin_, 2).store(out_.y.data());
    (main.pick(direction_, 1) * per).store(out_.shear_x.data());
    (main.pick(direction_, 2) * per).store(out_.shear_y.data());
    (per * Floats::set(1 + 0x1p-21f)).store(out_.per_depth.data());
    mul_add(off_, Floats::set(0x1.1p+1f),
            mul_add(most_origin_, Floats::set(0x1.1p-23f), Floats::set(kTiny)))
        .store(out_.error.data());
    set_culling(sign);
  }

  /// Sets the sign of determinants on the ignored side. N . d is negative at the front, and
  /// determinants have its sign times that of the main component.
  HWY_INLINE void set_culling(const Floats& sign) {
    const geometry::Culling culling = packet_.culling;
    const float turned = culling == geometry::Culling::kNone   ? 0.0f
                         : culling == geometry::Culling::kBack ? 1.0f
                                                               : -1.0f;
    (sign * Floats::set(turned)).store(out_.cull.data());
  }

  /// Sets the limits of t and depth. Returns the rays that may meet the bounds.
  HWY_INLINE std::uint32_t set_limits() {
    const Rays& rays = packet_.rays;
    const Doubles most = Doubles::set(kLargestT), least = Doubles::set(-kLargestT);
    const Doubles per_unit = Doubles::set(1) / Doubles::load(rays.unit.data()),
                  scale = Doubles::set(static_cast<double>(frame_.scale));
    const bool is_moved = far_ != 0 || frame_.scale != 1;
    const auto local = [&](const Doubles& t) {
      const Doubles at = t * per_unit;
      return to_floats(max(least, min(most, is_moved ? at * scale - shift_ : at)));
    };
    // A hit whose t overflows a double is no hit.
    const Doubles tmax =
        min(Doubles::load(rays.tmax.data()), Doubles::set(std::numeric_limits<double>::max()));
    const Floats begin = local(Doubles::load(rays.tmin.data())), end = local(tmax);
    const Floats best = local(min(tmax, Doubles::load(packet_.best->t.data())));
    const Floats slack = distance_ * Floats::set(0x1.1p-28f);
    t_in_ = max(t_in_, widened_down(begin, 0x1p-23f) - slack);
    t_out_ = min(t_out_, widened_up(best, 0x1p-23f) + slack);
    t_in_.store(out_.t_in.data());
    t_out_.store(out_.t_out.data());
    const Floats depth_slack = mul_add(
        distance_, Floats::set(0x1p-21f),
        mul_add(most_origin_, Floats::set(0x1p-22f), Floats::set(4 * frame_.error + kTiny)));
    depth_slack.store(out_.slack.data());
    constexpr float kRounding = 0x1p-21f;
    (widened_down(t_in_ * depth_, kRounding) - depth_slack).store(out_.low.data());
    (widened_up(t_out_ * depth_, kRounding) + depth_slack).store(out_.high.data());
    (widened_up(begin * depth_, kRounding) + depth_slack).store(out_.sure_low.data());
    (widened_down(end * depth_, kRounding) - depth_slack).store(out_.sure_high.data());
    return t_in_ <= t_out_;
  }

  Packet& packet_;
  const Frame& frame_;
  FloatRays& out_;
  std::array<Doubles, 3> from_;  // the origins before they are rounded to floats
  Doubles shift_ = Doubles::set(0);
  Floats off_ = Floats::set(0), far_distance_;
  std::array<Floats, 3> origin_, direction_;
  std::array<std::uint32_t, 3> octant_{};
  Floats most_origin_, distance_, t_in_, t_out_, depth_;
  std::uint32_t backward_ = 0;
  // The rays that begin far away; of these, the ones that pass beside the tree, and the ones of
  // which floats know nothing.
  std::uint32_t far_ = 0, beside_ = 0, blind_ = 0;
};

std::uint32_t prepare_packet(Packet& packet, const Frame& frame, std::uint32_t lanes) {
  return Preparing(packet, frame).prepare(lanes);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::wide {

HWY_EXPORT(prepare_packet);

std::uint32_t prepare(Packet& packet, const Frame& frame, std::uint32_t lanes) {
  if (packet.points != nullptr) return prepare_points(packet, frame, lanes);
  return HWY_DYNAMIC_DISPATCH(prepare_packet)(packet, frame, lanes);
}

void tighten(Packet& packet, std::size_t lane) {
  if (packet.points != nullptr) return tighten_point(packet, lane);
  FloatRays& floats = packet.floats;
  const double t =
      packet.best->t[lane] / packet.rays.unit[lane] * packet.scale - floats.shift[lane];
  // t is raised as in set_limits(): by the rounding to float, and by the slack of t, which is less
  // than that of depths.
  const auto out = static_cast<float>(std::clamp(t, -kLargestT, kLargestT));
  const float t_out = out + std::fabs(out) * 0x1p-23f + floats.slack[lane] * 0x1p-6f;
  floats.t_out[lane] = std::min(floats.t_out[lane], t_out);
  const float depth = t_out / floats.per_depth[lane];
  floats.high[lane] =
      std::min(floats.high[lane], depth + std::fabs(depth) * 0x1p-20f + floats.slack[lane]);
}

}  // namespace sightline::accel::wide
#endif  // HWY_ONCE

// The rays of a frustum as slopes over its main axis. docs/hit_rule.md, section 8, derives the
// constants.
#if defined(SIGHTLINE_WIDE_FRUSTUM_RAYS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_WIDE_FRUSTUM_RAYS_INL
#undef SIGHTLINE_WIDE_FRUSTUM_RAYS_INL
#else
#define SIGHTLINE_WIDE_FRUSTUM_RAYS_INL
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "accel/wide/float_rays.h"
#include "accel/wide/frame.h"
#include "accel/wide/frustum.h"
#include "accel/wide/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

/// Slopes of a frustum are at most this.
constexpr double kLargestSlope = 2;
/// Points, trees and rays with larger coordinates would overflow products.
constexpr double kLargestFrustum = 0x1p+50;
/// Ends of rays that are closer to each other, relative to the rays' size, are one point.
constexpr double kOneEnd = 0x1p-23;

/// What the rays of a frustum share. Axes are in the order that ends with the main axis, which is
/// turned so that the rays go from the point along it.
struct Point {
  std::array<std::size_t, 3> axis;  ///< The axes, the main axis last.
  bool backward;                    ///< Whether rays go down along the main axis.
  float sign;                       ///< -1 where the way from the point goes down along it, else 1.
  std::array<double, 3> at;         ///< The point, relative to the center of the tree.
  float error;                      ///< How far off rays may run, on each axis.
  /// The largest coordinate of the rays' origins, or of their ways to the point; 0 if they come
  /// from it.
  double reach;
  double size;  ///< The largest coordinate of the point and the tree.
  /// The first ray's slopes, on the other axes for a unit of the main one.
  std::array<double, 2> slope;
};

/// A frustum's first ray.
struct FirstRay {
  std::size_t packet, lane;

  explicit FirstRay(const FrustumLanes& lanes) {
    packet = 0;
    while (lanes[packet] == 0) ++packet;
    lane = static_cast<std::size_t>(std::countr_zero(lanes[packet]));
  }
};

/// The inverse of a power of two.
HWY_INLINE Doubles inverse_of_power(const Doubles& x) {
  return Doubles::each([&](std::size_t i) {
    const Doubles::D d;
    const hn::RebindToUnsigned<Doubles::D> bits;
    return hn::BitCast(
        d, hn::Sub(hn::Set(bits, std::uint64_t{2046} << 52), hn::BitCast(bits, x.v[i])));
  });
}

class FrustumRays {
 public:
  /// The rays in `lanes` are reduced to a frustum.
  HWY_INLINE FrustumRays(std::span<Packet> packets, const Frame& frame, FrustumLanes& lanes)
      : packets_(packets), frame_(frame), lanes_(lanes) {}

  /// Keeps rays with one origin; returns whether they are a frustum.
  HWY_INLINE bool from_origin() {
    if (!is_left()) return false;
    const FirstRay first(lanes_);
    const Rays& rays = packets_[first.packet].rays;
    std::array<double, 3> origin;
    for (std::size_t axis = 0; axis < 3; ++axis) origin[axis] = rays.origin[axis][first.lane];
    if (!starts_at(origin)) return false;
    const Doubles zero = Doubles::set(0);
    for (std::size_t p = 0; p < packets_.size(); ++p) {
      const Vectors from = load(packets_[p].rays.origin);
      lanes_[p] &= equal(from[0], Doubles::set(origin[0])) &
                   equal(from[1], Doubles::set(origin[1])) &
                   equal(from[2], Doubles::set(origin[2])) &
                   (Doubles::load(packets_[p].rays.tmin.data()) >= zero);
    }
    point.reach = 0;
    return is_left() && set_point(origin, 0, false);
  }

  /// Keeps rays with one end; returns whether they are a frustum.
  HWY_INLINE bool toward_end() {
    if (!is_left()) return false;
    const FirstRay first(lanes_);
    const Rays& rays = packets_[first.packet].rays;
    std::array<double, 3> end;
    double size = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double o = rays.origin[axis][first.lane],
                   d = rays.direction[axis][first.lane] / rays.unit[first.lane];
      end[axis] = o + d;
      size = std::max({size, std::fabs(o), std::fabs(d)});
    }
    double off = 0;
    point.reach = 0;
    for (std::size_t p = 0; p < packets_.size(); ++p)
      lanes_[p] &= ending_at(packets_[p].rays, end, size, off);
    return is_left() && set_point(end, off + 0x1p-47 * size, true);
  }

  /// Sets what floats know of the rays, by packet: slopes less the first ray's.
  HWY_INLINE void set_floats(bool from_origin) {
    const std::size_t main = point.axis[2];
    const Doubles turn = Doubles::set(from_origin ? 1.0 : -1.0);
    const float infinity = std::numeric_limits<float>::infinity();
    spread_lo = {infinity, infinity};
    spread_hi = {-infinity, -infinity};
    for (std::size_t p = 0; p < packets_.size(); ++p) {
      if (lanes_[p] == 0) continue;
      Packet& packet = packets_[p];
      FloatRays& out = packet.floats;
      const Doubles along = abs(Doubles::load(packet.rays.direction[main].data()));
      const Floats per = Floats::set(1) / to_floats(along);
      for (std::size_t k = 0; k < 2; ++k) {
        const Doubles across = Doubles::load(packet.rays.direction[point.axis[k]].data());
        const Floats slope =
            to_floats(neg_mul_add(along, Doubles::set(point.slope[k]), across * turn)) * per;
        slope.store(k == 0 ? out.shear_x.data() : out.shear_y.data());
        spread_lo[k] =
            std::min(spread_lo[k], Floats::pick(lanes_[p], slope, Floats::set(infinity)).least());
        spread_hi[k] = std::max(spread_hi[k],
                                Floats::pick(lanes_[p], slope, Floats::set(-infinity)).greatest());
      }
      (per * Floats::set(1 + 0x1p-21f)).store(out.per_depth.data());
      set_limits(packet, along, from_origin);
      set_culling(packet);
      packet.center = frame_.center;
      packet.candidates.has_best = 0;
      packet.candidates.count.fill(0);
    }
  }

  Point point;
  std::array<float, 2> spread_lo, spread_hi;  ///< Bounds of the slopes of set_floats().

 private:
  HWY_INLINE bool is_left() const {
    std::uint32_t any = 0;
    for (const std::uint32_t lanes : lanes_) any |= lanes;
    return any != 0;
  }

  /// Whether the first ray of the last packet starts at this origin: most rays that do not start at
  /// one point need no further test.
  HWY_INLINE bool starts_at(const std::array<double, 3>& origin) const {
    const Rays& rays = packets_.back().rays;
    return rays.origin[0][0] == origin[0] && rays.origin[1][0] == origin[1] &&
           rays.origin[2][0] == origin[2];
  }

  /// Returns the rays that end there; raises `most_off` and point.reach.
  HWY_INLINE std::uint32_t ending_at(const Rays& rays, const std::array<double, 3>& end,
                                     double size, double& most_off) {
    const Doubles per = inverse_of_power(Doubles::load(rays.unit.data()));
    Doubles off = Doubles::set(0), largest = off;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Doubles o = Doubles::load(rays.origin[axis].data()),
                    d = Doubles::load(rays.direction[axis].data()) * per;
      off = max(off, abs(o + d - Doubles::set(end[axis])));
      largest = max(largest, max(abs(o), abs(d)));
    }
    const std::uint32_t there = (off <= Doubles::set(kOneEnd * size)) &
                                (largest <= Doubles::set(16 * size)) &
                                (Doubles::load(rays.tmin.data()) >= Doubles::set(0)) &
                                (Doubles::load(rays.tmax.data()) <= Doubles::set(1));
    const Doubles zero = Doubles::set(0);
    most_off = std::max(most_off, Doubles::pick(there, off, zero).greatest());
    point.reach = std::max(point.reach, Doubles::pick(there, largest, zero).greatest());
    return there;
  }

  /// Sets the point and its axes by the first ray, and keeps the rays that run along the main axis.
  /// `toward`: rays run to the point. Returns whether coordinates are in range.
  HWY_INLINE bool set_point(const std::array<double, 3>& at, double error, bool toward) {
    const FirstRay first(lanes_);
    const Rays& rays = packets_[first.packet].rays;
    const auto component = [&](std::size_t axis) { return rays.direction[axis][first.lane]; };
    std::size_t main = 0;
    for (std::size_t axis = 1; axis < 3; ++axis) {
      if (std::fabs(component(axis)) > std::fabs(component(main))) main = axis;
    }
    point.axis = {(main + 1) % 3, (main + 2) % 3, main};
    point.backward = component(main) < 0;
    point.sign = point.backward == toward ? 1.0f : -1.0f;
    const Doubles forward = Doubles::set(point.backward ? -1.0 : 1.0);
    double size = static_cast<double>(largest_coordinate(frame_.bounds));
    for (std::size_t k = 0; k < 3; ++k) {
      point.at[k] = at[point.axis[k]] - static_cast<double>(frame_.center[point.axis[k]]);
      size = std::max(size, std::fabs(point.at[k]));
    }
    point.size = size;
    point.error = static_cast<float>(1.001 * (error + 0x1p-51 * size));
    for (std::size_t k = 0; k < 2; ++k) {
      const double slope = component(point.axis[k]) / std::fabs(component(main));
      point.slope[k] = toward ? -slope : slope;
    }
    for (std::size_t p = 0; p < packets_.size(); ++p) {
      const Vectors d = load(packets_[p].rays.direction);
      const Doubles along = d[main] * forward, most = along * Doubles::set(kLargestSlope);
      lanes_[p] &= (along > Doubles::set(0)) & (abs(d[point.axis[0]]) <= most) &
                   (abs(d[point.axis[1]]) <= most);
    }
    return std::max(size, point.reach) <= kLargestFrustum;
  }

  /// Sets the limits of depth, counted from the point.
  HWY_INLINE void set_limits(Packet& packet, const Doubles& along, bool from_origin) const {
    const Rays& rays = packet.rays;
    FloatRays& out = packet.floats;
    const Doubles per_t = along * inverse_of_power(Doubles::load(rays.unit.data()));
    // A hit whose t overflows a double is no hit.
    const Doubles tmin = Doubles::load(rays.tmin.data()),
                  tmax = min(Doubles::load(rays.tmax.data()),
                             Doubles::set(std::numeric_limits<double>::max())),
                  one = Doubles::set(1), most = Doubles::set(kFarthest);
    const auto depth = [&](const Doubles& t) { return to_floats(min(t * per_t, most)); };
    const Floats begin = depth(from_origin ? tmin : one - tmax);
    const Floats end = depth(from_origin ? tmax : one - tmin);
    const Floats best = from_origin ? depth(min(tmax, Doubles::load(packet.best->t.data()))) : end;
    const Floats slack = Floats::set(slack_of_depth());
    const Floats rounding = Floats::set(0x1p-21f);
    slack.store(out.slack.data());
    (neg_mul_add(begin, rounding, begin) - slack).store(out.low.data());
    (mul_add(best, rounding, best) + slack).store(out.high.data());
    (mul_add(begin, rounding, begin) + slack).store(out.sure_low.data());
    (neg_mul_add(end, rounding, end) - slack).store(out.sure_high.data());
    Floats::set(std::numeric_limits<float>::max()).store(out.t_out.data());
    Doubles::set(0).store(out.shift.data());
  }

  HWY_INLINE float slack_of_depth() const {
    float distance = 0, origin = 0;
    const auto reach = static_cast<float>(point.reach);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = static_cast<float>(point.at[k]);
      origin = std::max(origin, std::fabs(at));
      distance = std::max({distance, std::fabs(frame_.bounds.lo[point.axis[k]] - at),
                           std::fabs(frame_.bounds.hi[point.axis[k]] - at)});
    }
    return (distance + reach) * 0x1p-21f + (origin * 0x1p-22f + (2 * point.error + kTiny));
  }

  /// Sets the ignored side by the direction of the rays, also where they go toward the point.
  HWY_INLINE void set_culling(Packet& packet) const {
    const geometry::Culling culling = packet.culling;
    const float sign = point.backward ? -1.0f : 1.0f;
    Floats::set(culling == geometry::Culling::kNone   ? 0.0f
                : culling == geometry::Culling::kBack ? sign
                                                      : -sign)
        .store(packet.floats.cull.data());
  }

  /// Greater than any depth within a tree.
  static constexpr double kFarthest = 0x1p+100;

  std::span<Packet> packets_;
  const Frame& frame_;
  FrustumLanes& lanes_;
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#endif  // toggle

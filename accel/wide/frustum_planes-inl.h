// The triangles of a block as a frustum sees them: planes through the point and each edge.
// docs/hit_rule.md, section 8, derives the constants.
#if defined(SIGHTLINE_WIDE_FRUSTUM_PLANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_WIDE_FRUSTUM_PLANES_INL
#undef SIGHTLINE_WIDE_FRUSTUM_PLANES_INL
#else
#define SIGHTLINE_WIDE_FRUSTUM_PLANES_INL
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "accel/blocks/block.h"
#include "accel/wide/frustum_rays-inl.h"
#include "accel/wide/single-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

class FrustumPlanes {
 public:
  HWY_INLINE explicit FrustumPlanes(const FrustumRays& rays) : point_(rays.point) {
    float widest = 0x1p-20f;
    for (std::size_t k = 0; k < 2; ++k) {
      lo_[k] = Floats::set(rays.spread_lo[k]);
      hi_[k] = Floats::set(rays.spread_hi[k]);
      slope_[k] = Floats::set(static_cast<float>(point_.slope[k]));
      widest = std::max({widest, -rays.spread_lo[k], rays.spread_hi[k]});
    }
    const float unit = 0x1p-24f;
    per_width_ = Floats::set((64 + 20 * widest) * unit);
    per_depth_ = Floats::set(70 * widest * unit);
    const float off = 4 * point_.error + static_cast<float>(point_.size) * 0x1p-48f;
    beside_ = Floats::set((7 + 8 * widest) * off);
    tiny_ = Floats::set(kTiny + static_cast<float>(point_.size) * 0x1p-118f);
  }

  /// Returns the triangles that some ray may meet between two depths.
  HWY_INLINE std::uint32_t set(const blocks::Block& block, float nearest, float farthest) {
    Vertices seen, given;
    read(block, seen, given);
    std::array<Corner, 3> at, corner;
    for (std::size_t k = 0; k < 3; ++k) {
      const Gather of(block.corner(k));
      at[k] = seen.gather(of);
      corner[k] = given.gather(of);
    }
    const Corner ab = minus(corner[1], corner[0]), bc = minus(corner[2], corner[1]),
                 ca = minus(corner[0], corner[2]);
    const Floats width = most(beside(at[0]), beside(at[1]), beside(at[2])),
                 depth = most(abs(at[0].z), abs(at[1].z), abs(at[2].z)),
                 edge = most(largest(ab), largest(bc), largest(ca));
    const Floats bound =
        mul_add(edge, mul_add(width, per_width_, mul_add(depth, per_depth_, beside_)), tiny_);
    const std::array<Corner, 3> planes{across(at[0], sheared(ab)), across(at[1], sheared(bc)),
                                       across(at[2], sheared(ca))};
    bound.store(bound_.data());
    for (std::size_t k = 0; k < 3; ++k) {
      planes[k].x.store(x_[k].data());
      planes[k].y.store(y_[k].data());
      planes[k].z.store(z_[k].data());
      at[k].z.store(depth_[k].data());
    }
    const std::uint32_t all = (2u << (block.triangles - 1)) - 1;
    return all & ~(beside(planes, bound) | beyond(at, Floats::set(nearest), Floats::set(farthest)));
  }

  /// The rays with these slopes that one triangle does not certainly miss.
  HWY_INLINE std::uint32_t met(std::size_t i, const Floats& x, const Floats& y) const {
    const Floats ab = plane(0, i, x, y), bc = plane(1, i, x, y), ca = plane(2, i, x, y),
                 bound = Floats::set(bound_[i]);
    return ~((most(ab, bc, ca) > bound) & (least(ab, bc, ca) < neg(bound)));
  }

  /// The edges of one triangle, as rays with these slopes see them.
  HWY_INLINE Edges edges(std::size_t i, const Floats& x, const Floats& y) const {
    return {plane(0, i, x, y),        plane(1, i, x, y),         plane(2, i, x, y),
            Floats::set(bound_[i]),   Floats::set(depth_[0][i]), Floats::set(depth_[1][i]),
            Floats::set(depth_[2][i])};
  }

 private:
  HWY_INLINE Floats plane(std::size_t edge, std::size_t i, const Floats& x, const Floats& y) const {
    return mul_add(x, Floats::set(x_[edge][i]),
                   mul_add(y, Floats::set(y_[edge][i]), Floats::set(z_[edge][i])));
  }

  struct Vertices {
    Floats x, y, z;
    alignas(64) std::array<std::array<float, 16>, 3> stored;

    HWY_INLINE void store() {
      if constexpr (Floats::kVectors > 1) {
        x.store(stored[0].data());
        y.store(stored[1].data());
        z.store(stored[2].data());
      }
    }
    HWY_INLINE Corner gather(const Gather& of) const {
      return {of(x, stored[0].data()), of(y, stored[1].data()), of(z, stored[2].data())};
    }
  };

  /// Reads vertices: `seen` are relative to the point, and sheared so that the first ray runs along
  /// z; `given` are as they are. z grows along the rays' way from the point.
  HWY_INLINE void read(const blocks::Block& block, Vertices& seen, Vertices& given) const {
    const auto axis = [&](std::size_t k) {
      return Floats::load_unaligned(block.x + point_.axis[k] * block.vertices);
    };
    const auto from = [&](const Floats& v, std::size_t k) {
      return to_doubles(v) - Doubles::set(point_.at[k]);
    };
    const Floats sign = Floats::set(point_.sign);
    const Floats z = axis(2);
    given.x = axis(0);
    given.y = axis(1);
    given.z = z * sign;
    const Doubles depth = from(z, 2) * Doubles::set(static_cast<double>(point_.sign));
    seen.x = to_floats(neg_mul_add(depth, Doubles::set(point_.slope[0]), from(given.x, 0)));
    seen.y = to_floats(neg_mul_add(depth, Doubles::set(point_.slope[1]), from(given.y, 1)));
    seen.z = to_floats(depth);
    seen.store();
    given.store();
  }

  static HWY_INLINE Corner minus(const Corner& a, const Corner& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  static HWY_INLINE Floats largest(const Corner& a) { return most(abs(a.x), abs(a.y), abs(a.z)); }
  static HWY_INLINE Floats beside(const Corner& a) { return max(abs(a.x), abs(a.y)); }
  HWY_INLINE Corner sheared(const Corner& a) const {
    return {neg_mul_add(a.z, slope_[0], a.x), neg_mul_add(a.z, slope_[1], a.y), a.z};
  }
  static HWY_INLINE Corner across(const Corner& a, const Corner& b) {
    return {mul_sub(a.y, b.z, a.z * b.y), mul_sub(a.z, b.x, a.x * b.z),
            mul_sub(a.x, b.y, a.y * b.x)};
  }

  struct Interval {
    Floats lo, hi;
  };
  /// The range of a plane's values over all rays.
  HWY_INLINE Interval over_rays(const Corner& plane) const {
    const Floats a = plane.x * lo_[0], b = plane.x * hi_[0], c = plane.y * lo_[1],
                 d = plane.y * hi_[1];
    return {min(a, b) + (min(c, d) + plane.z), max(a, b) + (max(c, d) + plane.z)};
  }

  /// The triangles that lie to one side of all rays, by one of their edges.
  HWY_INLINE std::uint32_t beside(const std::array<Corner, 3>& planes, const Floats& bound) const {
    const Interval ab = over_rays(planes[0]), bc = over_rays(planes[1]), ca = over_rays(planes[2]);
    const Interval whole =
        over_rays({planes[0].x + planes[1].x + planes[2].x, planes[0].y + planes[1].y + planes[2].y,
                   planes[0].z + planes[1].z + planes[2].z});
    const Floats three = bound * Floats::set(4), zero = Floats::set(0);
    return ((whole.lo > three) & (least(ab.hi, bc.hi, ca.hi) < zero - bound)) |
           ((whole.hi < zero - three) & (most(ab.lo, bc.lo, ca.lo) > bound));
  }

  static HWY_INLINE std::uint32_t beyond(const std::array<Corner, 3>& at, const Floats& nearest,
                                         const Floats& farthest) {
    return (least(at[0].z, at[1].z, at[2].z) > farthest) |
           (most(at[0].z, at[1].z, at[2].z) < nearest);
  }

  const Point& point_;
  std::array<Floats, 2> lo_, hi_, slope_;
  Floats per_width_, per_depth_, beside_, tiny_;
  // The planes of a block's triangles by edge, and the depths of their corners.
  alignas(64) std::array<std::array<float, 16>, 3> x_, y_, z_, depth_;
  alignas(64) std::array<float, 16> bound_;
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#endif  // toggle

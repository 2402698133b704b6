// Projected vertices against four lines, with the error bound of the prefilter; vertices against
// the sides of a box and a plane.
#include "accel/geometry/vertex_sides.h"

#include <array>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/geometry/vertex_sides.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::geometry {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Finds the sides of as many vertices at once as D has lanes. kZ: ShearedRay::z.
template <std::size_t kZ, class D>
class Sides {
 public:
  using V = hn::Vec<D>;

  explicit Sides(const ShearedRay& ray)
      : x_(hn::Set(D(), ray.origin[0])),
        y_(hn::Set(D(), ray.origin[1])),
        z_(hn::Set(D(), ray.origin[2])),
        shear_x_(hn::Set(D(), ray.shear_x)),
        shear_y_(hn::Set(D(), ray.shear_y)),
        error_(hn::Set(D(), ray.error)) {}

  /// The error bound, with u = 2^-24 and n the largest coordinate relative to the origin: a
  /// projected vertex is off by `error` and 6 u n, so by less than `off`, and it is at most 2 n.
  /// Sums and differences of its coordinates are off by twice that and 4 u n, so by less than 3
  /// `off`. Numbers that are too large make the bound infinite or NaN, and then no bit is set.
  HWY_INLINE void store(const float* vertices, std::uint8_t* sides) const {
    const D d;
    V axis0, axis1, axis2;
    hn::LoadInterleaved3(d, vertices, axis0, axis1, axis2);
    const V x = hn::Sub(pick<(kZ + 1) % 3>(axis0, axis1, axis2), x_),
            y = hn::Sub(pick<(kZ + 2) % 3>(axis0, axis1, axis2), y_),
            z = hn::Sub(pick<kZ>(axis0, axis1, axis2), z_);
    const V n = hn::Max(hn::Abs(z), hn::Max(hn::Abs(x), hn::Abs(y)));
    const V off = hn::MulAdd(n, hn::Set(d, 0x1p-21f), error_);
    const V px = hn::Sub(x, hn::Mul(shear_x_, z)), py = hn::Sub(y, hn::Mul(shear_y_, z));
    const V off3 = hn::Mul(off, hn::Set(d, 3.0f));
    const auto bits =
        hn::Or(hn::Or(bit<1>(px, off), bit<4>(py, off)),
               hn::Or(bit<16>(hn::Add(px, py), off3), bit<64>(hn::Sub(px, py), off3)));
    hn::StoreU(hn::DemoteTo(hn::Rebind<std::uint8_t, D>(), bits), hn::Rebind<std::uint8_t, D>(),
               sides);
  }

 private:
  template <std::size_t kAxis>
  static HWY_INLINE V pick(V axis0, V axis1, V axis2) {
    if constexpr (kAxis == 0) return axis0;
    if constexpr (kAxis == 1) return axis1;
    return axis2;
  }

  /// kBit where `at` is certainly positive, twice that where it is certainly negative.
  template <int kBit>
  static HWY_INLINE hn::Vec<hn::RebindToSigned<D>> bit(V at, V off) {
    const hn::RebindToSigned<D> di;
    const auto above = hn::RebindMask(di, hn::Gt(at, off));
    const auto below = hn::RebindMask(di, hn::Lt(at, hn::Neg(off)));
    return hn::Or(hn::IfThenElseZero(above, hn::Set(di, kBit)),
                  hn::IfThenElseZero(below, hn::Set(di, 2 * kBit)));
  }

  V x_, y_, z_, shear_x_, shear_y_, error_;
};

/// As Sides, for a part of space.
template <class D>
class CutSides {
 public:
  using V = hn::Vec<D>;

  explicit CutSides(const CutBox& part) : part_(part) {}

  /// With u = 2^-24, the computed normal . v is off by at most 4 u of the sum of its terms without
  /// signs, which is off by 3 u of itself; the difference is rounded once. Numbers that are too
  /// large become NaN or infinite, and then the plane's bit is not set, or rightly so.
  HWY_INLINE void store(const float* vertices, std::uint8_t* sides) const {
    const D d;
    V axis0, axis1, axis2;
    hn::LoadInterleaved3(d, vertices, axis0, axis1, axis2);
    const V x = hn::Mul(axis0, hn::Set(d, part_.normal.x)),
            y = hn::Mul(axis1, hn::Set(d, part_.normal.y)),
            z = hn::Mul(axis2, hn::Set(d, part_.normal.z));
    const V size = hn::Add(hn::Add(hn::Abs(x), hn::Abs(y)), hn::Abs(z));
    const V least = hn::Sub(hn::Add(hn::Add(x, y), z), hn::Mul(size, hn::Set(d, 0x1p-21f)));
    const auto beyond = bit<64>(hn::Gt(least, hn::Set(d, part_.most)));
    const auto bits = hn::Or(hn::Or(outside<0, 1>(axis0), outside<1, 4>(axis1)),
                             hn::Or(outside<2, 16>(axis2), beyond));
    hn::StoreU(hn::DemoteTo(hn::Rebind<std::uint8_t, D>(), bits), hn::Rebind<std::uint8_t, D>(),
               sides);
  }

 private:
  template <int kBit, class M>
  static HWY_INLINE hn::Vec<hn::RebindToSigned<D>> bit(M mask) {
    const hn::RebindToSigned<D> di;
    return hn::IfThenElseZero(hn::RebindMask(di, mask), hn::Set(di, kBit));
  }
  template <std::size_t kAxis, int kBit>
  HWY_INLINE hn::Vec<hn::RebindToSigned<D>> outside(V at) const {
    const D d;
    return hn::Or(bit<kBit>(hn::Lt(at, hn::Set(d, part_.box.lo[kAxis]))),
                  bit<2 * kBit>(hn::Gt(at, hn::Set(d, part_.box.hi[kAxis]))));
  }

  const CutBox part_;
};

/// `Of<D>` finds the sides of as many vertices at once as D has lanes.
template <template <class> class Of, class Part>
HWY_INLINE void store_sides(const Part& part, std::span<const Vec3f> vertices,
                            std::uint8_t* sides) {
  using Several = hn::CappedTag<float, 16>;
  using One = hn::CappedTag<float, 1>;
  const Of<Several> several(part);
  const Of<One> one(part);
  const std::size_t lanes = hn::Lanes(Several());
  std::size_t i = 0;
  for (; i + lanes <= vertices.size(); i += lanes) several.store(&vertices[i].x, sides + i);
  for (; i < vertices.size(); ++i) one.store(&vertices[i].x, sides + i);
}

template <class D>
using SidesAlongX = Sides<0, D>;
template <class D>
using SidesAlongY = Sides<1, D>;
template <class D>
using SidesAlongZ = Sides<2, D>;

void sides_of_ray(const ShearedRay& ray, std::span<const Vec3f> vertices, std::uint8_t* sides) {
  if (ray.z == 0) return store_sides<SidesAlongX>(ray, vertices, sides);
  if (ray.z == 1) return store_sides<SidesAlongY>(ray, vertices, sides);
  store_sides<SidesAlongZ>(ray, vertices, sides);
}

void sides_of_part(const CutBox& part, std::span<const Vec3f> vertices, std::uint8_t* sides) {
  store_sides<CutSides>(part, vertices, sides);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::geometry
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::geometry {

HWY_EXPORT(sides_of_ray);
HWY_EXPORT(sides_of_part);

void vertex_sides(const ShearedRay& ray, std::span<const Vec3f> vertices, std::uint8_t* sides) {
  static_assert(sizeof(Vec3f) == 3 * sizeof(float));
  HWY_DYNAMIC_DISPATCH(sides_of_ray)(ray, vertices, sides);
}

void vertex_sides(const CutBox& part, std::span<const Vec3f> vertices, std::uint8_t* sides) {
  HWY_DYNAMIC_DISPATCH(sides_of_part)(part, vertices, sides);
}

std::size_t faces_on_no_side(std::span<const Face> faces, std::uint32_t begin, std::uint32_t end,
                             const std::uint8_t* sides, std::uint32_t* out) {
  std::size_t n = 0;
  for (std::uint32_t i = begin; i < end; ++i) {
    const Face& face = faces[i];
    out[n] = i;
    n += (sides[face[0]] & sides[face[1]] & sides[face[2]]) == 0 ? 1 : 0;
  }
  return n;
}

}  // namespace sightline::accel::geometry
#endif  // HWY_ONCE

// Edge functions in the plane in which the ray is a point, with a bound on their error.
#include "accel/geometry/triangle_prefilter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <hwy/cache_control.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/geometry/triangle_prefilter.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::geometry {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

std::uint64_t candidate_mask(const MeshView&, const ShearedRay&, std::span<const std::uint32_t>) {
  return ~std::uint64_t{0};
}

#else

/// Bounds the error of numbers too small to be normal.
constexpr float kTiny = 0x1p-100f;

/// One corner of each of several triangles, projected.
template <class D>
struct Projected {
  hn::Vec<D> x, y;

  HWY_INLINE hn::Vec<D> size() const { return hn::Max(hn::Abs(x), hn::Abs(y)); }
  HWY_INLINE hn::Vec<D> edge(const Projected& to) const {
    return hn::Sub(hn::Mul(x, to.y), hn::Mul(y, to.x));
  }
};

/// Loads one corner of faces 0, 4, 8, ...: three coordinates and the float behind them.
template <class D>
HWY_INLINE hn::Vec<D> load_fours(D d, const MeshView& mesh, const std::uint32_t* faces,
                                 std::size_t corner) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    return hn::LoadU(d, &mesh.vertices.data()[mesh.faces.data()[*faces][corner]].x);
  } else {
    const hn::Half<D> half;
    return hn::Combine(d, load_fours(half, mesh, faces + hn::MaxLanes(half), corner),
                       load_fours(half, mesh, faces, corner));
  }
}

/// One triangle for each lane of D; the lane count is a multiple of four. kZ: ShearedRay::z.
template <std::size_t kZ, class D>
class Triangles {
 public:
  using V = hn::Vec<D>;
  static constexpr std::size_t kLanes = hn::MaxLanes(D());

  explicit Triangles(const ShearedRay& ray) : ray_(ray) {}

  /// Bit i is set if triangle i is not certainly missed.
  ///
  /// The error bound, with u = 2^-24 and all sizes as computed. A vertex relative to the origin is
  /// off by error / 2 and its rounding. A projected vertex is off by `error` and six roundings of
  /// the largest coordinate n, so by E = error + 8 u n. Each of the two products of an edge
  /// function is off by 2 E m + E^2, where m is the largest projected coordinate; rounding them and
  /// their difference adds 4 u m^2. 4.25 E (m + E) + 8 u m^2 is above the sum. Numbers that are too
  /// large make the bound infinite or NaN, and then no triangle is a miss.
  HWY_INLINE std::uint64_t possible(const MeshView& mesh, const std::uint32_t* faces) const {
    const D d;
    if (reads_last(mesh, faces)) return (std::uint64_t{1} << kLanes) - 1;
    V n = hn::Zero(d);
    const Projected<D> a = project(mesh, faces, 0, n), b = project(mesh, faces, 1, n),
                       c = project(mesh, faces, 2, n);
    const V off = hn::MulAdd(n, hn::Set(d, 0x1p-21f), hn::Set(d, ray_.error));
    const V m = hn::Max(hn::Max(a.size(), b.size()), c.size());
    const V rounding = hn::MulAdd(hn::Mul(m, m), hn::Set(d, 0x1p-21f), hn::Set(d, kTiny));
    const V bound = hn::MulAdd(hn::Add(m, off), hn::Mul(off, hn::Set(d, 4.25f)), rounding);
    const V minus = hn::Neg(bound);
    const V ab = a.edge(b), bc = b.edge(c), ca = c.edge(a);
    const auto left = hn::Or(hn::Or(hn::Gt(ab, bound), hn::Gt(bc, bound)), hn::Gt(ca, bound));
    const auto right = hn::Or(hn::Or(hn::Lt(ab, minus), hn::Lt(bc, minus)), hn::Lt(ca, minus));
    const auto possible = hn::Not(hn::And(left, right));
    if (hn::AllFalse(d, possible)) return 0;
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, possible, bits);
    return bits[0] | static_cast<std::uint64_t>(bits[1]) << 8;
  }

 private:
  /// The memory behind the last vertex may not be readable.
  static HWY_INLINE bool reads_last(const MeshView& mesh, const std::uint32_t* faces) {
    const std::size_t last = mesh.vertices.size() - 1;
    unsigned reads = 0;
    for (std::size_t i = 0; i < kLanes; ++i) {
      const Face& face = mesh.faces.data()[faces[i]];
      reads |= unsigned{face[0] == last} | unsigned{face[1] == last} | unsigned{face[2] == last};
    }
    return reads != 0;
  }

  /// Raises n to the largest coordinate.
  HWY_INLINE Projected<D> project(const MeshView& mesh, const std::uint32_t* faces,
                                  std::size_t corner, V& n) const {
    const D d;
    const V r0 = load_fours(d, mesh, faces, corner), r1 = load_fours(d, mesh, faces + 1, corner),
            r2 = load_fours(d, mesh, faces + 2, corner),
            r3 = load_fours(d, mesh, faces + 3, corner);
    const V xy_even = hn::InterleaveLower(d, r0, r2), xy_odd = hn::InterleaveLower(d, r1, r3);
    const V z_even = hn::InterleaveUpper(d, r0, r2), z_odd = hn::InterleaveUpper(d, r1, r3);
    const std::array<V, 3> axes{hn::InterleaveLower(d, xy_even, xy_odd),
                                hn::InterleaveUpper(d, xy_even, xy_odd),
                                hn::InterleaveLower(d, z_even, z_odd)};
    const V x = hn::Sub(axes[(kZ + 1) % 3], hn::Set(d, ray_.origin[0]));
    const V y = hn::Sub(axes[(kZ + 2) % 3], hn::Set(d, ray_.origin[1]));
    const V z = hn::Sub(axes[kZ], hn::Set(d, ray_.origin[2]));
    n = hn::Max(n, hn::Max(hn::Abs(z), hn::Max(hn::Abs(x), hn::Abs(y))));
    return {hn::Sub(x, hn::Mul(hn::Set(d, ray_.shear_x), z)),
            hn::Sub(y, hn::Mul(hn::Set(d, ray_.shear_y), z))};
  }

  const ShearedRay& ray_;
};

/// Works on whole vectors: lanes beyond the end repeat the last face.
template <std::size_t kZ, class D>
HWY_INLINE std::uint64_t possible(const MeshView& mesh, const ShearedRay& ray,
                                  std::span<const std::uint32_t> faces) {
  const Triangles<kZ, D> triangles(ray);
  constexpr std::size_t kLanes = Triangles<kZ, D>::kLanes;
  std::uint64_t found = 0;
  std::size_t i = 0;
  for (; i + kLanes <= faces.size(); i += kLanes)
    found |= triangles.possible(mesh, faces.data() + i) << i;
  if (i == faces.size()) return found;
  std::array<std::uint32_t, kLanes> rest;
  rest.fill(faces.back());
  std::copy(faces.begin() + static_cast<std::ptrdiff_t>(i), faces.end(), rest.begin());
  return found | triangles.possible(mesh, rest.data()) << i;
}

template <class D>
HWY_INLINE std::uint64_t possible(const MeshView& mesh, const ShearedRay& ray,
                                  std::span<const std::uint32_t> faces) {
  if (ray.z == 0) return possible<0, D>(mesh, ray, faces);
  if (ray.z == 1) return possible<1, D>(mesh, ray, faces);
  return possible<2, D>(mesh, ray, faces);
}

/// Prefetches all of them, so that cache misses overlap.
HWY_INLINE void fetch(const MeshView& mesh, std::span<const std::uint32_t> faces) {
  for (const std::uint32_t face : faces) hwy::Prefetch(mesh.faces.data() + face);
  for (const std::uint32_t face : faces) {
    for (const std::uint32_t v : mesh.faces.data()[face]) hwy::Prefetch(mesh.vertices.data() + v);
  }
}

std::uint64_t candidate_mask(const MeshView& mesh, const ShearedRay& ray,
                             std::span<const std::uint32_t> faces) {
  if (faces.size() <= 4) return possible<hn::CappedTag<float, 4>>(mesh, ray, faces);
  if (faces.size() <= 8) return possible<hn::CappedTag<float, 8>>(mesh, ray, faces);
  if (faces.size() > 16) fetch(mesh, faces);
  return possible<hn::CappedTag<float, 16>>(mesh, ray, faces);
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::geometry
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::geometry {

HWY_EXPORT(candidate_mask);

ShearedRay sheared(const LocalRay& ray) {
  constexpr auto kMost = static_cast<double>(std::numeric_limits<float>::max());
  const Vec3d& d = ray.direction;
  ShearedRay out;
  out.z = 0;
  for (const std::size_t axis : {std::size_t{1}, std::size_t{2}}) {
    if (std::fabs(d[axis]) > std::fabs(d[out.z])) out.z = axis;
  }
  const std::size_t x = (out.z + 1) % 3, y = (out.z + 2) % 3;
  double error = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double o = ray.origin[(x + k) % 3];
    out.origin[k] = static_cast<float>(std::clamp(o, -kMost, kMost));
    error = std::max(error, std::fabs(o - static_cast<double>(out.origin[k])));
  }
  out.shear_x = static_cast<float>(d[x] / d[out.z]);
  out.shear_y = static_cast<float>(d[y] / d[out.z]);
  // The bound is twice the error: that of x, and that of the multiple of z subtracted from it. The
  // last term rounds up.
  constexpr float kTiny = 0x1p-100f;
  out.error = error < kMost / 3 ? static_cast<float>(2.001 * error) + kTiny
                                : std::numeric_limits<float>::infinity();
  return out;
}

std::uint64_t candidate_mask(const MeshView& mesh, const ShearedRay& ray,
                             std::span<const std::uint32_t> faces) {
  const std::uint64_t found = HWY_DYNAMIC_DISPATCH(candidate_mask)(mesh, ray, faces);
  return found & (~std::uint64_t{0} >> (kPrefilterBatch - faces.size()));
}

}  // namespace sightline::accel::geometry
#endif  // HWY_ONCE

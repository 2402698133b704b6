// What floats say of sixteen pairs of a ray and a triangle: a certain miss, a certain hit in an
// interval of depth, or neither. docs/hit_rule.md, section 7, has the proof.
#if defined(SIGHTLINE_WIDE_VERDICT_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_WIDE_VERDICT_INL
#undef SIGHTLINE_WIDE_VERDICT_INL
#else
#define SIGHTLINE_WIDE_VERDICT_INL
#endif

#include <array>
#include <cstdint>

#include "accel/wide/float_rays.h"
#include "accel/wide/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

using Floats = Lanes<float, 16>;

/// A corner of each triangle, as its ray sees it: the ray is the line x = y = 0, and z is depth.
struct Corner {
  Floats x, y, z;
};

/// What the verdict needs to know of the rays.
struct Limits {
  Floats error, low, high, cull;
};

struct Verdict {
  /// Pairs that are not certainly missed, nor certainly at a depth that does not help.
  std::uint32_t possible = 0;
  std::uint32_t certain = 0;  ///< The possible pairs that are certainly hit.
  Floats depth, off;          ///< The depth of hits, and how far it may be off.
};

HWY_INLINE Floats most(const Floats& a, const Floats& b, const Floats& c) {
  return max(max(a, b), c);
}
HWY_INLINE Floats least(const Floats& a, const Floats& b, const Floats& c) {
  return min(min(a, b), c);
}

/// Decides by the determinants of the edges and a bound on their errors. Returns whether any pair
/// is possible.
HWY_INLINE bool judge(const std::array<Corner, 3>& corners, const Limits& limits,
                      std::uint32_t lanes, Verdict& out) {
  const auto& [a, b, c] = corners;
  const Floats size = max(most(abs(a.x), abs(b.x), abs(c.x)), most(abs(a.y), abs(b.y), abs(c.y)));
  const Floats near = least(a.z, b.z, c.z), far = most(a.z, b.z, c.z);
  const Floats deepest = max(abs(near), abs(far));
  const Floats error = mul_add(size + deepest, Floats::set(0x1p-20f), limits.error);
  const Floats bound = mul_add(error * Floats::set(4.25f), size + error,
                               mul_add(size * size, Floats::set(0x1p-21f), Floats::set(kTiny)));
  const Floats ab = mul_sub(a.x, b.y, a.y * b.x), bc = mul_sub(b.x, c.y, b.y * c.x),
               ca = mul_sub(c.x, a.y, c.y * a.x);
  const Floats zero = Floats::set(0);
  const Floats greatest = most(ab, bc, ca), smallest = zero - least(ab, bc, ca);
  const std::uint32_t missed =
      ((greatest > bound) & (smallest > bound)) | (near > limits.high) | (far < limits.low);
  out.possible = lanes & ~missed;
  if (out.possible == 0) return false;
  const Floats whole = ab + bc + ca, inverse = Floats::set(1) / whole;
  out.depth = mul_add(bc * inverse, a.z, mul_add(ca * inverse, b.z, ab * inverse * c.z));
  const Floats share = abs(bound * Floats::set(6.5f) * inverse);
  const Floats weights = share + Floats::set(1);
  out.off = mul_add(share, far - near, deepest * Floats::set(0x1p-20f) * weights * weights);
  out.possible &= ~(((out.depth - out.off) > limits.high) | ((out.depth + out.off) < limits.low));
  // All determinants certainly have one sign: the least is above the bound, or the greatest below
  // its negative.
  const std::uint32_t one_sign = (zero - smallest > bound) | (zero - greatest > bound);
  out.possible &= ~(one_sign & (whole * limits.cull > zero));
  out.certain = out.possible & one_sign;
  return out.possible != 0;
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#endif  // toggle

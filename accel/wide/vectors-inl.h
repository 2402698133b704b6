// Vectors of all rays of a packet in doubles. Nothing is fused, as in geometry/vec3.h.
#if defined(SIGHTLINE_WIDE_VECTORS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_WIDE_VECTORS_INL
#undef SIGHTLINE_WIDE_VECTORS_INL
#else
#define SIGHTLINE_WIDE_VECTORS_INL
#endif

#include <array>

#include "accel/wide/lanes-inl.h"
#include "accel/wide/packet.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

using Doubles = Lanes<double, kLanes>;
/// A vector of each ray, by axis.
using Vectors = std::array<Doubles, 3>;

HWY_INLINE Vectors load(const std::array<Column<double>, 3>& columns) {
  return {Doubles::load(columns[0].data()), Doubles::load(columns[1].data()),
          Doubles::load(columns[2].data())};
}
HWY_INLINE Vectors minus(const Vectors& a, const Vectors& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
HWY_INLINE Vectors cross(const Vectors& a, const Vectors& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
HWY_INLINE Doubles dot(const Vectors& a, const Vectors& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
HWY_INLINE Doubles max_norm(const Vectors& a) { return max(max(abs(a[0]), abs(a[1])), abs(a[2])); }

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#endif  // toggle

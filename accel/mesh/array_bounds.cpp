// Loops as wide as the machine's vectors, with equal results on every SIMD target.
#include "accel/mesh/array_bounds.h"

#include <algorithm>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/mesh/array_bounds.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::mesh {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

std::uint32_t greatest(const std::uint32_t* indices, std::size_t count) {
  const hn::ScalableTag<std::uint32_t> d;
  const std::size_t lanes = hn::Lanes(d);
  auto a = hn::Zero(d), b = a;
  std::size_t i = 0;
  for (; i + 2 * lanes <= count; i += 2 * lanes) {
    a = hn::Max(a, hn::LoadU(d, indices + i));
    b = hn::Max(b, hn::LoadU(d, indices + i + lanes));
  }
  std::uint32_t most = hn::GetLane(hn::MaxOfLanes(d, hn::Max(a, b)));
  for (; i < count; ++i) most = std::max(most, indices[i]);
  return most;
}

/// Computes the bounds of values x, y, z, x, ..., three vectors at a time, so that each lane always
/// has the same axis. Returns false if a value is not finite.
bool bounds(const float* values, std::size_t count, geometry::Aabb& box) {
  const hn::ScalableTag<float> d;
  const std::size_t lanes = hn::Lanes(d);
  const auto none = hn::Set(d, std::numeric_limits<float>::infinity());
  auto lo0 = none, lo1 = none, lo2 = none;
  auto hi0 = hn::Neg(none), hi1 = hi0, hi2 = hi0;
  auto zero = hn::Zero(d);  // NaN once a value is not finite
  std::size_t i = 0;
  for (; i + 3 * lanes <= count; i += 3 * lanes) {
    const auto a = hn::LoadU(d, values + i), b = hn::LoadU(d, values + i + lanes),
               c = hn::LoadU(d, values + i + 2 * lanes);
    lo0 = hn::Min(lo0, a);
    lo1 = hn::Min(lo1, b);
    lo2 = hn::Min(lo2, c);
    hi0 = hn::Max(hi0, a);
    hi1 = hn::Max(hi1, b);
    hi2 = hn::Max(hi2, c);
    zero = hn::Add(zero, hn::Add(hn::Sub(a, a), hn::Add(hn::Sub(b, b), hn::Sub(c, c))));
  }
  constexpr std::size_t kMostFloats = std::size_t{3} * HWY_MAX_BYTES / sizeof(float);
  HWY_ALIGN float lo[kMostFloats], hi[kMostFloats];
  hn::Store(lo0, d, lo);
  hn::StoreU(lo1, d, lo + lanes);
  hn::StoreU(lo2, d, lo + 2 * lanes);
  hn::Store(hi0, d, hi);
  hn::StoreU(hi1, d, hi + lanes);
  hn::StoreU(hi2, d, hi + 2 * lanes);
  for (std::size_t k = 0; k < 3 * lanes; ++k) {
    box.lo[k % 3] = std::min(box.lo[k % 3], lo[k]);
    box.hi[k % 3] = std::max(box.hi[k % 3], hi[k]);
  }
  bool finite = hn::AllTrue(d, hn::Eq(zero, hn::Zero(d)));
  for (; i < count; ++i) {
    finite &= values[i] - values[i] == 0;
    box.lo[i % 3] = std::min(box.lo[i % 3], values[i]);
    box.hi[i % 3] = std::max(box.hi[i % 3], values[i]);
  }
  return finite;
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::mesh
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::mesh {

HWY_EXPORT(greatest);
HWY_EXPORT(bounds);

std::uint32_t greatest_index(std::span<const geometry::Face> faces) {
  return faces.empty() ? 0 : HWY_DYNAMIC_DISPATCH(greatest)(faces.data()->data(), 3 * faces.size());
}

std::optional<geometry::Aabb> bounds_of_vertices(std::span<const geometry::Vec3f> vertices) {
  geometry::Aabb box;
  if (vertices.empty() ||
      !HWY_DYNAMIC_DISPATCH(bounds)(&vertices.data()->x, 3 * vertices.size(), box))
    return std::nullopt;
  return box;
}

geometry::Aabb bounds_of_faces(const geometry::MeshView& mesh, std::size_t stride) {
  geometry::Aabb box;
  for (std::size_t i = 0; i < mesh.faces.size(); i += stride) {
    for (const std::uint32_t v : mesh.faces[i]) box.grow(mesh.vertices[v]);
  }
  return box;
}

}  // namespace sightline::accel::mesh
#endif  // HWY_ONCE

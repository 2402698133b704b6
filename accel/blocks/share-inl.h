// Finds the vertices that triangles share. Compiled once per SIMD target.
#if defined(SIGHTLINE_BLOCKS_SHARE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_BLOCKS_SHARE_INL
#undef SIGHTLINE_BLOCKS_SHARE_INL
#else
#define SIGHTLINE_BLOCKS_SHARE_INL
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "accel/blocks/shared_vertices.h"
#include "accel/geometry/triangle_mesh.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::blocks {
namespace HWY_NAMESPACE {

inline constexpr std::size_t kMostCorners = 3 * kBlockTriangles;

/// Writes for each number the position of the first that equals it. Compares all pairs without a
/// branch. Reads and writes whole vectors of the aligned lists.
HWY_INLINE void find_first(const std::uint32_t* numbers, std::size_t count, std::uint32_t* first) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::CappedTag<std::uint32_t, 16> d;
  const std::size_t lanes = hn::Lanes(d);
  for (std::size_t i = 0; i < count; i += lanes) {
    const auto own = hn::Load(d, numbers + i);
    auto found = hn::Zero(d);
    for (std::size_t j = std::min(count, i + lanes); j-- > 0;) {
      const auto equal = hn::Eq(own, hn::Set(d, numbers[j]));
      found = hn::IfThenElse(equal, hn::Set(d, static_cast<std::uint32_t>(j)), found);
    }
    hn::Store(found, d, first + i);
  }
}

/// Finds the distinct vertices of the triangles `ids`, 1 to kBlockTriangles. Returns false if there
/// are more than kBlockVertices.
HWY_INLINE bool share(const geometry::MeshView& mesh, const std::uint32_t* ids, std::size_t count,
                      SharedVertices& shared) {
  alignas(64) std::uint32_t corners[kMostCorners], first[kMostCorners], rank[kMostCorners];
  for (std::size_t i = 0; i < count; ++i) {
    const geometry::Face& face = mesh.faces.data()[ids[i]];
    for (std::size_t k = 0; k < 3; ++k) corners[k * count + i] = face[k];
  }
  find_first(corners, 3 * count, first);
  std::uint32_t distinct = 0;
  for (std::uint32_t j = 0; j < 3 * count; ++j) {
    shared.vertices[distinct] = corners[j];
    rank[j] = distinct;
    distinct += first[j] == j ? 1 : 0;
  }
  if (distinct > kBlockVertices) return false;
  shared.count = distinct;
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < count; ++i)
      shared.corners[k][i] = static_cast<std::uint8_t>(rank[first[k * count + i]]);
  }
  return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::blocks
HWY_AFTER_NAMESPACE();

#endif  // toggle

// Perfect splits: a straddler's box shrinks to the part of its triangle in the child. Source: Wald,
// Havran 2006, section 3.4 (after Hurley et al. 2002).
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "accel/geometry/clip.h"
#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/reference.h"

namespace sightline::accel::grow {

/// Bounds of the part of a face in one half of a cell that the face is held by; nothing if it only
/// touches that half.
///
/// An axis along which the whole triangle is flat is not asked about: it may lie in the cell's
/// face, and which cells hold it then was decided by the cut that made the face
/// (Split::planar_left).
inline std::optional<geometry::Aabb> clip_to_half(const geometry::MeshView& mesh,
                                                  std::uint32_t face, const geometry::Aabb& half) {
  const geometry::Face& f = mesh.faces[face];
  const geometry::Vec3f &a = mesh.vertices[f[0]], &b = mesh.vertices[f[1]],
                        &c = mesh.vertices[f[2]];
  const std::optional<geometry::Aabb> box = clipped_bounds(a, b, c, half);
  if (!box) return std::nullopt;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool overlaps = box->lo[axis] < half.hi[axis] && box->hi[axis] > half.lo[axis];
    const bool flat = a[axis] == b[axis] && b[axis] == c[axis];
    if (!overlaps && !flat) return std::nullopt;
  }
  return box;
}

/// In: one side's list after sifting by `plane`, and that side's cell. Straddlers are clipped from
/// their original triangle, those that do not reach into the cell after all are left out, the
/// others keep their order. Openable references stay as they are. Returns how many are left.
inline std::size_t clip_straddlers(const geometry::MeshView& mesh,
                                   std::span<kdtree::Reference> list, const kdtree::Plane& plane,
                                   const geometry::Aabb& cell) {
  const auto axis = static_cast<std::size_t>(plane.axis);
  std::size_t kept = 0;
  for (kdtree::Reference ref : list) {
    if (!ref.openable() && ref.lo[axis] < plane.position && ref.hi[axis] > plane.position) {
      const std::optional<geometry::Aabb> box = clip_to_half(mesh, ref.id, cell);
      if (!box) continue;
      ref.lo = box->lo;
      ref.hi = box->hi;
    }
    list[kept++] = ref;
  }
  return kept;
}

}  // namespace sightline::accel::grow

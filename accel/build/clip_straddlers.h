// Perfect splits: a straddler's box shrinks to the part of its triangle in the child. Source: Wald, Havran 2006,
// section 3.4 (after Hurley et al. 2002).
#pragma once

#include <cstddef>
#include <span>

#include "accel/build/box_ref.h"
#include "accel/geometry/clip.h"
#include "accel/geometry/mesh_view.h"

namespace sightline::accel {

/// In: one side's list after sifting by `plane`, and that side's cell. Straddlers are clipped from their original
/// triangle, those that do not reach into the cell after all are left out, the others keep their order. Returns how many
/// are left.
inline std::size_t clip_straddlers(const MeshView& mesh, std::span<BoxRef> list, const Plane& plane, const Aabb& cell) {
  const auto axis = static_cast<std::size_t>(plane.axis);
  std::size_t kept = 0;
  for (BoxRef ref : list) {
    if (ref.lo[axis] < plane.position && ref.hi[axis] > plane.position) {
      const Face& f = mesh.faces[ref.id];
      const std::optional<Aabb> box =
          clipped_bounds(mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]], cell);
      if (!box || !is_member(*box, cell)) continue;
      ref.lo = box->lo;
      ref.hi = box->hi;
    }
    list[kept++] = ref;
  }
  return kept;
}

}  // namespace sightline::accel

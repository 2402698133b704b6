// The references that a mesh's tree starts from: its faces, or runs of them.
#pragma once

#include <memory>

#include "accel/geometry/triangle_mesh.h"
#include "accel/lazy/reference_source.h"

namespace sightline::accel::mesh {

/// Returns the source of a mesh's references. `bounds`: box of the finite triangles. `may_run`: use
/// runs if they are compact, which the first call of the source decides. `alive`: see
/// ReferenceSource.
lazy::ReferenceSource source_of_faces(const geometry::MeshView& mesh, const geometry::Aabb& bounds,
                                      bool may_run, std::shared_ptr<const void> alive);

}  // namespace sightline::accel::mesh

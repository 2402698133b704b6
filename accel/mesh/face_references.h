// A mesh's faces, or runs of them, as references for its tree to begin with.
#pragma once

#include <memory>

#include "accel/geometry/triangle_mesh.h"
#include "accel/lazy/reference_source.h"

namespace sightline::accel::mesh {

/// `bounds`: of the finite triangles. Whether runs are made of the faces, where they may be, is
/// decided by whoever asks first. `alive`: see ReferenceSource.
lazy::ReferenceSource source_of_faces(const geometry::MeshView& mesh, const geometry::Aabb& bounds,
                                      bool may_run, std::shared_ptr<const void> alive);

}  // namespace sightline::accel::mesh

// A mesh's faces, or runs of them, as references for its tree to begin with.
#pragma once

#include <memory>

#include "accel/geometry/triangle_mesh.h"
#include "accel/lazy/reference_source.h"
#include "accel/split/kd_builder.h"

namespace sightline::accel::mesh {

/// Whether the builder's trees may begin with runs. Those are opened by the rule of membership,
/// which builders do not follow that choose the side of flat boxes.
inline bool takes_runs(const split::KdBuilder& builder) {
  return !std::holds_alternative<published::kd::ExactBuilder>(builder);
}

/// `bounds`: of the finite triangles. Whether runs are made of the faces, where they may be, is
/// decided by whoever asks first. `alive`: see ReferenceSource.
lazy::ReferenceSource source_of_faces(const geometry::MeshView& mesh, const geometry::Aabb& bounds,
                                      bool may_run, std::shared_ptr<const void> alive);

}  // namespace sightline::accel::mesh

// Parts of the mesh that a node has.
#pragma once

#include "proto/result.h"
#include "server/scenes/services.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::server::updates {

/// Answers SceneService.ReadMesh. Errors: kNotFound (the scene or the node), kFailedPrecondition (a
/// node without a mesh), kOutOfRange (the revision is not kept).
Status read_mesh(const scenes::Services& services, const v1::ReadMeshRequest& request,
                 v1::ReadMeshResponse& reply);

}  // namespace sightline::server::updates

// Uploads one mesh in chunks. Internal to the library.
#pragma once

#include <stop_token>
#include <string>

#include "client/mesh_blob.h"
#include "client/result.h"

namespace sightline::client::calls {

struct Connection;

Status upload_mesh(const Connection& connection, const MeshBlob& mesh, const std::string& digest,
                   const UploadProgress& progress, const std::stop_token& stop);

}  // namespace sightline::client::calls

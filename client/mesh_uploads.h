// Uploads of many meshes, several at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <string>

#include "client/client.h"
#include "client/mesh_blob.h"
#include "client/scene_upload.h"

namespace sightline::client {

/// A server that keeps meshes on disk acknowledges each after the disk has it. These wait
/// together, and share a commit.
inline constexpr std::size_t kUploadsAtATime = 8;
/// The most bytes at a time, unless one mesh alone has more: the server reserves memory for each.
inline constexpr std::uint64_t kUploadBytesAtATime = std::uint64_t{32} << 20;

struct MeshUpload {
  const MeshBlob* blob = nullptr;
  std::string digest;
};

/// Ends with the first error; other uploads may be done then. `progress` is called by one thread at
/// a time, with numbers that only grow. Errors: as Client::upload_mesh().
Status upload_all(const Client& client, std::span<const MeshUpload> uploads,
                  const std::stop_token& stop, const SceneUploadProgress& progress);

}  // namespace sightline::client

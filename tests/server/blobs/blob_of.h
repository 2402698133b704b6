// Meshes in the form that clients upload.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "server/blobs/mesh_blob.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

/// The blob of a mesh, as described in proto/sightline/v1/blob.proto.
std::string blob_of(const TestMesh& mesh);

/// The digest of these bytes.
server::blobs::BlobDigest digest_of(const std::string& bytes);

inline std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

}  // namespace sightline::tests

// Meshes as the bytes that clients upload.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "server/blobs/mesh_blob.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

/// The blob that proto/sightline/v1/blob.proto describes.
std::string blob_of(const TestMesh& mesh);

/// The digest that names these bytes.
server::blobs::BlobDigest digest_of(const std::string& bytes);

inline std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

}  // namespace sightline::tests

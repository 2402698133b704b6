// The bytes of a mesh as a blob, read as they arrive.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "proto/result.h"
#include "scenegraph/model/mesh.h"
#include "server/blobs/digest.h"

namespace sightline::server::blobs {

inline constexpr std::size_t kMeshBlobHeader = 24;  ///< Bytes before the positions.

/// Calls part() with the bytes of the mesh's blob, piece after piece. Makes the mesh resident; the
/// caller holds no lock. Ends with the first error.
Status write_mesh_blob(const scenegraph::model::Mesh& mesh,
                       const std::function<Status(std::span<const std::byte>)>& part);

/// The name of the mesh's blob. Cost: reads the whole mesh.
BlobDigest digest_of(const scenegraph::model::Mesh& mesh);

/// Reads the bytes of a mesh. proto/sightline/v1/blob.proto documents the layout.
class MeshBlobReader {
 public:
  /// `size`: bytes of the whole blob.
  explicit MeshBlobReader(std::uint64_t size) : size_(size) {}

  /// Adds the next bytes. Resident memory grows with the bytes that have arrived, not with the
  /// header's counts. Errors: kInvalidArgument (not a mesh, or its counts disagree with its size,
  /// or bytes beyond its end), kResourceExhausted (too many faces). After an error the reader must
  /// not be used.
  Status append(std::span<const std::byte> bytes);

  std::uint64_t received() const { return received_; }

  /// Makes the mesh after all bytes have arrived. The arrays move into it. `builder` makes its
  /// tree. Errors: kInvalidArgument (bytes are missing, an index is out of range), as Mesh::make.
  Result<std::shared_ptr<const scenegraph::model::Mesh>> finish(
      const accel::mesh::TreeBuilder& builder = {});

 private:
  Status read_header();

  const std::uint64_t size_;
  std::uint64_t received_ = 0;
  std::array<std::byte, kMeshBlobHeader> header_{};
  std::uint64_t positions_end_ = 0;  // offset in the blob
  std::vector<accel::geometry::Vec3f> vertices_;
  std::vector<accel::geometry::Face> faces_;
};

}  // namespace sightline::server::blobs

// A mesh as a blob: the digest that names it, and its bytes, read as they arrive.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/result.h"
#include "scenegraph/model/mesh.h"

struct evp_md_ctx_st;

namespace sightline::server::blobs {

using Sha256Sum = std::array<std::uint8_t, 32>;

/// SHA-256 of bytes that arrive in pieces.
class Sha256 {
 public:
  /// Throws std::bad_alloc where the library cannot give a context.
  Sha256();

  void update(std::span<const std::byte> bytes);
  /// The sum of all bytes. Call it once, after the last update().
  Sha256Sum finish();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

/// The name of a blob, "sha256:<64 hex digits>/<size in bytes>".
struct BlobDigest {
  Sha256Sum sum{};
  std::uint64_t size = 0;  ///< Bytes.

  auto operator<=>(const BlobDigest&) const = default;

  /// Takes only the canonical form (lower-case digits, no leading zeros), so that equal digests are
  /// equal text. Errors: kInvalidArgument.
  static Result<BlobDigest> parse(std::string_view text);
  std::string text() const;
};

inline constexpr std::size_t kMeshBlobHeader = 24;  ///< Bytes before the positions.

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

  /// Makes the mesh after all bytes have arrived. The arrays move into it.
  /// Errors: kInvalidArgument (bytes are missing, an index is out of range), as
  /// Mesh::make.
  Result<std::shared_ptr<const scenegraph::model::Mesh>> finish();

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

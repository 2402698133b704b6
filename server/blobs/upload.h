// One upload of a blob in progress: its bytes so far and their checksum.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>

#include "accel/result.h"
#include "scenegraph/model/mesh.h"
#include "server/blobs/blob_digest.h"
#include "server/blobs/mesh_blob.h"

namespace sightline::server::blobs {

class Upload {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Upload(const BlobDigest& digest)
      : digest_(digest), content_(std::in_place, digest.size) {}

  const BlobDigest& digest() const { return digest_; }
  std::uint64_t committed() const { return committed_.load(); }  ///< Bytes taken so far.
  Clock::time_point last_active() const { return last_active_.load(); }

  /// Adds the bytes at `offset`, which must equal committed().
  /// Errors: kOutOfRange (another offset), kAborted (dropped meanwhile), as MeshBlobReader::append.
  Status append(std::uint64_t offset, std::span<const std::byte> bytes);

  /// Errors: kDataLoss (the bytes do not match the digest), kAborted, as
  /// MeshBlobReader::finish.
  Result<std::shared_ptr<const scenegraph::model::Mesh>> finish();

  /// Frees the content, unless a thread uses it now. Returns whether it was freed.
  bool drop();

 private:
  struct Content {
    explicit Content(std::uint64_t size) : reader(size) {}
    MeshBlobReader reader;
    Sha256 sum;
  };

  const BlobDigest digest_;
  std::atomic<std::uint64_t> committed_{0};
  std::atomic<Clock::time_point> last_active_{Clock::now()};
  std::mutex mutex_;                // held while content_ is used
  std::optional<Content> content_;  // empty once dropped
};

}  // namespace sightline::server::blobs

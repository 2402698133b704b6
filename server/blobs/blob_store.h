// Meshes by the digest of their bytes, and uploads in progress, within one memory budget.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "accel/result.h"
#include "scenegraph/model/mesh.h"
#include "server/blobs/mesh_blob.h"

namespace sightline::server::blobs {

/// One upload of a blob in progress: its bytes so far and their checksum. Threads: any, for every
/// member.
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

  /// Makes the mesh after all bytes have arrived. Errors: kDataLoss (the bytes do not match the
  /// digest), kAborted, as MeshBlobReader::finish.
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

struct BlobLimits {
  std::uint64_t memory_budget = std::uint64_t{1}
                                << 30;  ///< Bytes: meshes, and uploads at their full size.
  std::size_t uploads = 64;             ///< At a time, including those set aside.
  /// An upload without new bytes for this long may be dropped.
  std::chrono::steady_clock::duration idle = std::chrono::seconds(10);
};

/// How much of a blob has arrived: an upload resumes at byte `committed`.
struct UploadStatus {
  std::uint64_t committed = 0;
  bool complete = false;
};

/// Threads: any, for every member. Two uploads of one digest are independent; the mesh of the first
/// to complete is kept.
class BlobStore {
 public:
  using MeshPointer = std::shared_ptr<const scenegraph::model::Mesh>;

  explicit BlobStore(BlobLimits limits) : limits_(limits) {}

  /// Null if there is no such mesh.
  MeshPointer find(const BlobDigest& digest) const;

  /// Starts an upload at `offset` 0, or resumes the one that was set aside at `offset`. To stay
  /// within the budget it drops, oldest first: uploads set aside, then meshes that no scene uses,
  /// then idle uploads. Errors: kInvalidArgument (too small for a mesh), kOutOfRange (no upload to
  /// resume at this offset), kResourceExhausted (naming the use and the limit).
  Result<std::shared_ptr<Upload>> begin(const BlobDigest& digest, std::uint64_t offset);

  /// Checks and keeps the mesh. The upload ends in any case. Cost: proportional to the mesh.
  /// Errors: as Upload::finish.
  Result<MeshPointer> complete(const std::shared_ptr<Upload>& upload);

  /// Keeps the upload so that a later call can resume it. Of two with one digest the longer is
  /// kept.
  void set_aside(const std::shared_ptr<Upload>& upload);
  /// Removes the upload.
  void abandon(const std::shared_ptr<Upload>& upload);

  UploadStatus status(const BlobDigest& digest) const;
  std::uint64_t bytes_used() const;  ///< Part of the memory budget that is used.

 private:
  struct Pending {
    std::shared_ptr<Upload> upload;
    bool set_aside = false;
  };
  struct Stored {
    MeshPointer mesh;
    std::uint64_t bytes = 0;
    std::uint64_t order = 0;  // of arrival
  };
  using PendingList = std::list<Pending>;
  using Freed = std::vector<std::shared_ptr<const void>>;

  PendingList::const_iterator set_aside_of(const BlobDigest& digest) const;
  Result<std::shared_ptr<Upload>> resume(const BlobDigest& digest, std::uint64_t offset);
  void erase(const Upload* upload);
  Status evict_for(std::uint64_t bytes, Freed& freed);
  bool drop_upload(bool idle, Freed& freed);
  bool drop_unused_mesh(Freed& freed);

  const BlobLimits limits_;
  mutable std::mutex mutex_;
  PendingList pending_;  // oldest first
  std::map<BlobDigest, Stored> meshes_;
  std::uint64_t bytes_used_ = 0;
  std::uint64_t next_order_ = 0;
};

}  // namespace sightline::server::blobs

// Meshes by the digest of their bytes, and the uploads on their way to become meshes, within one
// memory budget.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "accel/result.h"
#include "scenegraph/model/mesh.h"
#include "server/blobs/blob_digest.h"
#include "server/blobs/upload.h"

namespace sightline::server::blobs {

struct BlobLimits {
  std::uint64_t memory_budget = std::uint64_t{1}
                                << 30;  ///< Bytes: meshes, and uploads at their full size.
  std::size_t uploads = 64;             ///< At once, those set aside included.
  /// An upload that nothing was added to for this long may be dropped.
  std::chrono::steady_clock::duration idle = std::chrono::seconds(10);
};

/// Where an upload of a blob stands: from which byte it can be taken up again.
struct UploadStatus {
  std::uint64_t committed = 0;
  bool complete = false;
};

/// Threads: any, for every member. Two uploads of one digest do not see each other; the first to
/// end wins.
class BlobStore {
 public:
  using MeshPointer = std::shared_ptr<const scenegraph::model::Mesh>;

  explicit BlobStore(BlobLimits limits) : limits_(limits) {}

  /// Null if there is no such mesh (any more).
  MeshPointer find(const BlobDigest& digest) const;

  /// An upload to add to. `offset` 0 begins anew; anything else takes up the one that was set aside
  /// there. When room is short, what nobody needs is dropped: uploads set aside, then meshes that
  /// no scene uses, oldest first, then uploads that stand still. Errors: kInvalidArgument (too
  /// small for a mesh), kOutOfRange (nothing to take up at this offset), kResourceExhausted (naming
  /// what is used and the limit).
  Result<std::shared_ptr<Upload>> begin(const BlobDigest& digest, std::uint64_t offset);

  /// Checks and keeps the mesh; the upload is over, well or not. Takes time in proportion to the
  /// mesh. Errors: as Upload::finish.
  Result<MeshPointer> complete(const std::shared_ptr<Upload>& upload);

  /// Keeps the upload for somebody to take up again; of two of one digest, the longer.
  void set_aside(const std::shared_ptr<Upload>& upload);
  /// Forgets the upload.
  void abandon(const std::shared_ptr<Upload>& upload);

  UploadStatus status(const BlobDigest& digest) const;
  std::uint64_t bytes_used() const;  ///< Of the memory budget.

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
  Status make_room(std::uint64_t bytes, Freed& freed);
  bool drop_upload(bool standing_still, Freed& freed);
  bool drop_unused_mesh(Freed& freed);

  const BlobLimits limits_;
  mutable std::mutex mutex_;
  PendingList pending_;  // oldest first
  std::map<BlobDigest, Stored> meshes_;
  std::uint64_t bytes_used_ = 0;
  std::uint64_t next_order_ = 0;
};

}  // namespace sightline::server::blobs

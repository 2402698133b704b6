// Meshes by the digest of their bytes, and the uploads in progress.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "proto/result.h"
#include "scenegraph/model/mesh.h"
#include "server/blobs/mesh_blob.h"
#include "server/blobs/upload.h"
#include "server/blobs/upload_shares.h"
#include "server/exec/caller.h"
#include "server/exec/memory_account.h"
#include "server/exec/quotas.h"
#include "server/store/store.h"

namespace sightline::server::blobs {

struct BlobLimits {
  std::size_t uploads = 64;  ///< Uploads at a time, including those set aside.
  /// An upload without progress for this long, or that is slow after it, may be dropped.
  std::chrono::steady_clock::duration idle = std::chrono::seconds(10);
  /// A mesh that arrived within this time is fresh: its client may be about to use it.
  std::chrono::steady_clock::duration fresh = std::chrono::minutes(1);
  /// A mesh on disk that nothing has used for this long is dropped from memory.
  std::chrono::steady_clock::duration unused_on_disk = std::chrono::minutes(1);
  /// Without a disk, a mesh that nothing has used for this long is dropped.
  std::chrono::steady_clock::duration unused = std::chrono::minutes(30);
  /// A mesh that scenes have used, and no client has asked for since, is dropped after this.
  std::chrono::steady_clock::duration released = std::chrono::seconds(5);
};

/// Which unused meshes may be dropped.
enum class Unused : std::uint8_t { kStale, kAny };

/// How much of a blob has arrived: an upload resumes at byte `committed`.
struct UploadStatus {
  std::uint64_t committed = 0;
  bool complete = false;
};

/// With a store, meshes are kept on disk, and their arrays are read when a ray or an update first
/// needs them; what is always in memory is what all meshes are checked for.
/// Threads: any, for every member. Two uploads of one digest are independent; the mesh of the first
/// to complete is kept.
class BlobStore {
 public:
  using MeshPointer = std::shared_ptr<const scenegraph::model::Mesh>;

  /// Meshes, and what has arrived of uploads, are charged to `memory`, and trees count there.
  /// `disk`: null for none. Both outlive this object.
  explicit BlobStore(exec::MemoryAccount& memory, BlobLimits limits = {},
                     store::Store* disk = nullptr);

  /// Whether load() finds the mesh. If so, it is neither dropped nor swept soon.
  bool has(const BlobDigest& digest) const;
  /// Whether each is stored; they are asked for at once.
  std::vector<bool> has(std::span<const BlobDigest> digests) const;
  /// The mesh; from disk if it is not in memory, and then read once to check it, and not resident.
  /// Errors: kNotFound, kResourceExhausted (the memory budget), kDataLoss (its file is corrupt).
  Result<MeshPointer> load(const BlobDigest& digest);
  /// Loads a mesh for a scene, with the errors of load(). It is released when no scene has it any
  /// more.
  Result<MeshPointer> use(const BlobDigest& digest);
  /// A mesh of its own: `base` with the vertices of this one on disk. Errors: as load().
  Result<MeshPointer> load_patched(const scenegraph::model::Mesh& base, const BlobDigest& digest);
  /// Keeps the mesh on disk, where there is one, and returns its name. Waits for the disk. Errors:
  /// as store::Store::write_blob and BlobWriter::finish.
  Result<BlobDigest> keep(const scenegraph::model::Mesh& mesh);
  /// The mesh if it is in memory, else null.
  MeshPointer find(const BlobDigest& digest) const;

  /// Starts an upload at `offset` 0, or resumes the one that was set aside at `offset`. Its bytes
  /// count when they arrive, for the one who began it. Where uploads are too many or too large, of
  /// the server or of the caller, those set aside are dropped, oldest first, then idle ones.
  /// `stored` is kept as long as the upload, and then the mesh; a resumed upload keeps what it
  /// began with. Errors: kInvalidArgument (too small for a mesh), kOutOfRange (no upload to resume
  /// at this offset), kResourceExhausted (it could never fit, or as UploadShares::take), as
  /// store::Store::write_blob.
  Result<std::shared_ptr<Upload>> begin(const BlobDigest& digest, std::uint64_t offset,
                                        const exec::Caller& caller, exec::Quotas::Use stored = {});

  /// A slot for other content that arrives in parts. Errors: as UploadShares::take.
  Result<std::unique_ptr<UploadShares::Slot>> take_slot(const exec::Caller& caller) {
    return upload_shares_.take(caller);
  }

  /// Checks and keeps the mesh. The upload ends in any case. Cost: proportional to the mesh.
  /// Errors: as Upload::finish.
  Result<MeshPointer> complete(const std::shared_ptr<Upload>& upload);

  /// Keeps the upload so that a later call can resume it. If two have one digest, the longer is
  /// kept.
  void set_aside(const std::shared_ptr<Upload>& upload);
  /// Removes the upload.
  void abandon(const std::shared_ptr<Upload>& upload);

  UploadStatus status(const BlobDigest& digest) const;

  /// Drops the oldest upload that is set aside. Returns whether there was one.
  bool drop_set_aside();
  /// Drops the oldest upload without progress for BlobLimits::idle. Returns whether there was one.
  bool drop_idle();
  /// Drops the oldest mesh that nothing uses; with kStale, unless it is fresh. Returns the bytes of
  /// its tree; nothing if there was none.
  std::optional<std::uint64_t> drop_unused_mesh(Unused which);
  /// Drops the meshes that nothing has used for BlobLimits::unused or, after scenes have used them,
  /// BlobLimits::released, as far as calls of this could see: call it often.
  void drop_unused_meshes();
  /// Removes meshes from the disk that nothing names and nothing in this process uses. Needs a
  /// disk. Returns and errors: as store::Store::sweep().
  Result<std::uint64_t> sweep(Upload::Clock::duration grace);
  /// All meshes in memory.
  std::vector<MeshPointer> meshes() const;

 private:
  struct Pending {
    std::shared_ptr<Upload> upload;
    exec::Quotas::Use stored;
    bool set_aside = false;
  };
  struct Stored {
    MeshPointer mesh;
    exec::MemoryAccount::Charge charge;
    std::uint64_t order = 0;  // counts arrivals
    Upload::Clock::time_point arrived = {};
    mutable Upload::Clock::time_point used = arrived;  // or asked for
    mutable bool released = false;                     // used by a scene, not asked for since
  };
  using PendingList = std::list<Pending>;
  class Source;

  /// The builder of the trees of all meshes, which count in the account.
  accel::mesh::TreeBuilder builder() const { return {.memory = memory_.trees()}; }
  /// `charge`: for the bytes of a resident mesh. A mesh on disk is not resident.
  MeshPointer insert(const BlobDigest& digest, MeshPointer mesh,
                     exec::MemoryAccount::Charge charge);
  Result<MeshPointer> read(const BlobDigest& digest) const;
  Result<std::unique_ptr<store::BlobWriter>> writer(const BlobDigest& digest);
  PendingList::const_iterator set_aside_of(const BlobDigest& digest) const;
  Result<std::shared_ptr<Upload>> resume(const BlobDigest& digest, std::uint64_t offset);
  void erase(const Upload* upload);
  /// Whether an upload of this caller may go to make room in this scope.
  using MayGo = std::function<bool(const exec::Caller& owner)>;
  bool drop_upload(bool idle, const MayGo& may_go);

  exec::MemoryAccount& memory_;
  const BlobLimits limits_;
  store::Store* const disk_;
  UploadShares upload_shares_;
  mutable std::mutex mutex_;
  PendingList pending_;  // oldest first
  std::map<BlobDigest, Stored> meshes_;
  std::map<BlobDigest, exec::Quotas::Use> quotas_;  // uploaded meshes that are still stored
  std::uint64_t next_order_ = 0;
};

}  // namespace sightline::server::blobs

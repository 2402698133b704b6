// What a server keeps of its scenes and meshes beyond its own life: one interface for every engine.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/blobs/digest.h"
#include "server/store/limits.h"

namespace sightline::server::store {

/// The store's number of a scene; never used again, also after the scene's removal.
using SceneId = std::int64_t;

/// The type of scenegraph::model::NodeId.
using NodeId = std::uint64_t;

enum class UpAxis : std::uint8_t { kUnspecified = 0, kY = 1, kZ = 2 };

/// What a scene is created with. Nothing of it changes later.
struct SceneInfo {
  std::string name;               ///< Resource name; unique among scenes.
  std::uint64_t incarnation = 0;  ///< Told to clients in revision tokens.
  UpAxis up_axis = UpAxis::kUnspecified;
  double meters_per_unit = 0;  ///< 0: unknown.
};

/// A scene as it is kept.
struct SceneRecord {
  SceneId id = 0;
  SceneInfo info;
  std::uint64_t revision = 0;  ///< The newest; 0 before the first batch.
  /// The oldest complete snapshot, which the log continues; 0: the log begins at revision 1.
  std::uint64_t base = 0;
  std::vector<std::uint64_t> snapshots;  ///< Revisions of complete snapshots, ascending.
  std::uint64_t log_bytes = 0;           ///< Bytes of the updates after `base`.
  /// The scene's row is damaged, or its log was cut: calls for it end with kDataLoss.
  bool damaged = false;
};

/// The answer to a request with a request id.
struct RequestAnswer {
  std::string request_id;
  std::uint64_t content = 0;   ///< Digest of the request.
  std::uint64_t revision = 0;  ///< The revision that the request made.
  std::vector<NodeId> nodes;   ///< The nodes that it put, in order.
};

/// A numbered batch of a producer, applied or rejected.
struct ProducerCommit {
  std::string producer;
  std::uint64_t sequence = 0;
  std::vector<NodeId> nodes;  ///< The nodes that it put, in order; empty for a rejected batch.
};

/// A producer of a scene, and what is kept of its last batches.
struct ProducerRecord {
  std::string name;
  std::uint64_t last_committed = 0;    ///< Sequence number.
  std::vector<ProducerCommit> recent;  ///< Ascending in sequence; StoreLimits bounds them.
};

/// The outcome of a batch: whether it is kept. The store sets it before it calls `done`; until then
/// it may change.
struct BatchOutcome {
  std::atomic<bool> kept{false};
};

/// What is committed as one: wholly or not at all.
struct Batch {
  SceneId scene = 0;
  /// The newest revision before this batch. With updates, the batch makes the next revision.
  std::uint64_t expected = 0;
  /// The updates, in a form that the store does not read. Nothing: no revision is made, and only
  /// the producers' progress is recorded.
  std::optional<std::string> updates;
  std::vector<blobs::BlobDigest> blobs;  ///< Blobs that the updates name; they must be stored.
  std::optional<RequestAnswer> answer;
  std::vector<ProducerCommit> commits;  ///< In order; ascending sequences of each producer.
  /// The outcome of this batch. Null: no batch names it.
  std::shared_ptr<BatchOutcome> outcome = {};
  /// The outcome of the batch before it, if that was appended and is not done. If that batch is not
  /// kept, this one is not either, even if another process has made the revision `expected`.
  std::shared_ptr<const BatchOutcome> after = {};
};

/// The newest revision of a scene.
struct SceneHead {
  SceneId id = 0;
  std::uint64_t revision = 0;
};

/// A revision in the log.
struct LoggedBatch {
  std::uint64_t revision = 0;
  std::chrono::system_clock::time_point time;  ///< The time of the commit, in whole milliseconds.
  std::string updates;
};

/// The bytes of a blob, unchanged as long as the object lives, also if the blob is swept meanwhile.
class BlobBytes {
 public:
  virtual ~BlobBytes() = default;
  virtual std::span<const std::byte> bytes() const = 0;
};

/// A blob that is being stored. Without finish() nothing stays of it. Threads: one at a time. Must
/// not outlive its store.
class BlobWriter {
 public:
  virtual ~BlobWriter() = default;

  /// Adds the next bytes. After an error the writer must not be used. Errors: kInvalidArgument
  /// (more bytes than the digest says), kResourceExhausted (no disk left), kUnavailable.
  virtual Status append(std::span<const std::byte> bytes) = 0;

  /// Makes the blob durable. Waits for the disk. Call it once, after all bytes. If the blob was
  /// stored meanwhile, that one is kept. Errors: kDataLoss (the bytes do not match the digest),
  /// as append().
  virtual Status finish() = 0;
};

/// Figures for metrics and readiness.
struct StoreFigures {
  std::uint64_t commits = 0;                ///< Transactions so far.
  std::uint64_t batches = 0;                ///< Batches in them.
  std::uint64_t failures = 0;               ///< Transactions that failed.
  std::chrono::nanoseconds commit_time{0};  ///< Sum over all transactions.
  std::uint64_t batches_in_flight = 0;
  std::uint64_t bytes_in_flight = 0;
  std::uint64_t log_bytes = 0;  ///< Updates of all scenes.
  std::uint64_t blobs = 0;      ///< Number.
  std::uint64_t blob_bytes = 0;
  std::uint64_t bytes_on_disk = 0;  ///< Everything in the directory.
  std::uint64_t bytes_free = 0;     ///< Bytes that the file system has left for this process.
};

/// Keeps scenes, their update logs and the blobs that they name. What a call has reported as done
/// survives the death of the process and a loss of power. Threads: any, for every member.
///
/// Errors that every member may return, with the file and the remedy in the message: kUnavailable
/// (STORE_IO: the disk has failed the call; of a write it is then unknown whether it was kept
/// until the store is opened again), kResourceExhausted (DISK_FULL), kDataLoss (STORE_CORRUPT: what
/// the call needs is damaged; everything else is served).
class Store {
 public:
  virtual ~Store() = default;

  /// The next chunk of a snapshot, of at most kMaxSnapshotChunk bytes; empty: there are no more.
  using NextChunk = std::function<Result<std::string>()>;

  // --- Scenes. The writing calls wait for the disk.

  /// Errors: kAlreadyExists, kResourceExhausted.
  virtual Result<SceneId> create_scene(const SceneInfo& info) = 0;
  /// Creates a scene whose log begins after `revision`, with what put_snapshot() would store as its
  /// base (none for revision 0); with `replace` in place of the scene of this name, if there is
  /// one: until it returns, that one stays. If it fails, nothing has changed. Errors:
  /// kAlreadyExists, kResourceExhausted, kFailedPrecondition (BLOB_NOT_STORED), those of `next`.
  virtual Result<SceneId> restore_scene(const SceneInfo& info, std::uint64_t revision,
                                        const std::vector<blobs::BlobDigest>& blobs,
                                        const NextChunk& next, bool replace) = 0;
  /// Removes the scene with its log, answers, producers and snapshots. Batches that are in flight
  /// end first. Errors: kNotFound.
  virtual Status remove_scene(SceneId scene) = 0;
  /// All scenes, by name. Cost: proportional to their number, not to what they hold.
  virtual Result<std::vector<SceneRecord>> scenes() = 0;
  /// Errors: kNotFound.
  virtual Result<SceneRecord> scene(SceneId scene) = 0;
  /// The scene of this name; nothing: there is none.
  virtual Result<std::optional<SceneRecord>> find_scene(const std::string& name) = 0;
  /// The newest revisions of all scenes, by id.
  virtual Result<std::vector<SceneHead>> heads() = 0;

  // --- The update log.

  /// Called once, on the store's own thread: success once the batch is durable. Must be short, must
  /// not throw, and may call no other member of the store than append().
  using Done = std::function<void(const Status& committed)>;

  /// Queues a batch. Batches are committed, and `done` called, in the order of the calls. Batches
  /// may follow before the first is done; if one fails, those of its scene that build on its
  /// revision fail too, with kAborted. Returns an error, and never calls `done`, if nothing was
  /// queued: kResourceExhausted (a limit of StoreLimits, naming its value), kInvalidArgument.
  /// Errors of `done`: kAborted (REVISION_MISMATCH), kNotFound (no such scene), kFailedPrecondition
  /// (BLOB_NOT_STORED), kAlreadyExists (the request id is known), kOutOfRange (a producer's
  /// sequence is not beyond its last), kResourceExhausted (LOG_FULL, DISK_FULL, TOO_MANY_BYTES).
  virtual Status append(Batch batch, Done done) = 0;

  /// Waits until all that was queued before is done.
  virtual void flush() = 0;

  /// The batches after `after`, in order: as many as fit into `max_bytes` of updates, but at least
  /// one if there is one. Fewer, or none: there are no more. Errors: kNotFound, kOutOfRange
  /// (batches after `after` have been dropped; the message names the base), kDataLoss (a damaged
  /// row, after which the log cannot be followed).
  virtual Result<std::vector<LoggedBatch>> read(SceneId scene, std::uint64_t after,
                                                std::uint64_t max_bytes) = 0;

  /// The blobs that the base of the scene and the batches after it name.
  virtual Result<std::vector<blobs::BlobDigest>> blobs_of(SceneId scene) = 0;

  /// The last answers, oldest first, as many as StoreLimits keeps.
  virtual Result<std::vector<RequestAnswer>> answers(SceneId scene) = 0;
  /// The answer to the request of this id, if it is kept.
  virtual Result<std::optional<RequestAnswer>> answer(SceneId scene,
                                                      const std::string& request_id) = 0;
  /// All producers, by name.
  virtual Result<std::vector<ProducerRecord>> producers(SceneId scene) = 0;
  /// The producer of this name, if it has committed anything.
  virtual Result<std::optional<ProducerRecord>> producer(SceneId scene,
                                                         const std::string& name) = 0;

  // --- Snapshots: a scene at a revision, in a form that the store does not read.

  /// Stores a snapshot. Waits for the disk after each chunk, so that batches are committed between.
  /// `blobs`: the blobs that it names. If it fails, nothing of it stays. If two calls store one
  /// revision, the earlier ends with kAborted. Errors: kNotFound, kOutOfRange (beyond the newest
  /// revision, or older than the base), kAlreadyExists, kFailedPrecondition (BLOB_NOT_STORED),
  /// those of `next`.
  virtual Status put_snapshot(SceneId scene, std::uint64_t revision,
                              const std::vector<blobs::BlobDigest>& blobs,
                              const NextChunk& next) = 0;
  /// Chunk `index`, from 0; empty after the last. Errors: kNotFound, kDataLoss.
  virtual Result<std::string> read_snapshot(SceneId scene, std::uint64_t revision,
                                            std::uint64_t index) = 0;
  /// Makes the snapshot of this revision the base: drops the batches up to it and older snapshots.
  /// Their space is reused later, step by step. Errors: kNotFound, kFailedPrecondition (there is no
  /// complete snapshot of it).
  virtual Status drop_before(SceneId scene, std::uint64_t revision) = 0;

  // --- Blobs.

  /// Errors: kResourceExhausted (no disk left for it; it counts with its full size), kAlreadyExists
  /// (it is stored; as has_blob()).
  virtual Result<std::unique_ptr<BlobWriter>> write_blob(const blobs::BlobDigest& digest) = 0;
  /// Whether each blob is stored. If so, its grace period begins anew.
  virtual std::vector<bool> has_blobs(std::span<const blobs::BlobDigest> digests) = 0;
  bool has_blob(const blobs::BlobDigest& digest) {
    return has_blobs(std::span(&digest, 1)).front();
  }
  /// The blob, mapped. It is verified against its digest by the first call in the life of the
  /// store. Errors: kNotFound, kDataLoss (BLOB_CORRUPT).
  virtual Result<std::shared_ptr<const BlobBytes>> blob(const blobs::BlobDigest& digest) = 0;
  /// Removes the blobs that no batch and no snapshot names, that were not stored or asked for
  /// within the grace period, and that `in_use` (may be empty) does not claim. Returns the bytes
  /// of those removed. Waits for the disk.
  virtual Result<std::uint64_t> sweep(
      std::chrono::steady_clock::duration grace,
      const std::function<bool(const blobs::BlobDigest&)>& in_use) = 0;

  // --- State.

  virtual StoreFigures figures() const = 0;
  virtual const StoreLimits& limits() const = 0;
  /// Success if writes are taken: the last one did not fail, and the disk has room.
  virtual Status writable() = 0;

  // --- Other processes.

  /// Whether other processes write to the store, too: then a scene may have revisions that this one
  /// has not made, and an append() that conflicts with a commit of another process ends with
  /// kAborted (REVISION_MISMATCH).
  virtual bool shared() const { return false; }

  /// Scenes that may have changed; none: any of all. What has changed is then read by revision.
  using Changed = std::function<void(std::span<const SceneId> scenes)>;

  /// From now on calls `changed`, on a thread of the store, soon after another process has
  /// committed, and for all scenes about every kWatchEvery while the store can be reached. Call it
  /// once. Must not throw.
  virtual void watch(const Changed& /*changed*/) {}
  /// When it returns, `changed` is not running and will not be called.
  virtual void unwatch() {}
};

/// How late a commit of another process is noticed if its notice is lost.
inline constexpr std::chrono::milliseconds kWatchEvery{250};

/// The most bytes of a chunk of a snapshot.
inline constexpr std::size_t kMaxSnapshotChunk = std::size_t{4} << 20;

}  // namespace sightline::server::store

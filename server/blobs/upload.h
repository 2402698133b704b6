// One upload of a blob in progress.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>

#include "proto/result.h"
#include "scenegraph/model/mesh.h"
#include "server/blobs/mesh_blob.h"
#include "server/blobs/upload_shares.h"
#include "server/store/store.h"

namespace sightline::server::blobs {

/// An upload makes progress with each part of this many bytes.
inline constexpr std::uint64_t kUploadProgress = std::uint64_t{64} << 10;

/// An upload that gets fewer bytes a second stands still.
inline constexpr std::uint64_t kUploadPace = std::uint64_t{16} << 10;

/// One upload of a blob in progress: its bytes so far and their checksum. With a writer, they also
/// go to disk. Threads: any, for every member.
class Upload {
 public:
  using Clock = std::chrono::steady_clock;

  /// `slot`: where its bytes are booked before they are taken.
  Upload(const BlobDigest& digest, std::unique_ptr<UploadShares::Slot> slot,
         std::unique_ptr<store::BlobWriter> writer = nullptr)
      : digest_(digest),
        slot_(std::move(slot)),
        content_(std::in_place, digest.size, std::move(writer)) {}

  const BlobDigest& digest() const { return digest_; }
  const exec::Caller& caller() const { return slot_->caller(); }
  std::uint64_t committed() const { return committed_.load(); }  ///< Bytes taken so far.
  /// When it last made progress: got kUploadProgress bytes, or all that were missing.
  Clock::time_point last_progress() const { return last_progress_.load(); }

  /// Whether it has made no progress since then, or has begun before and not kept kUploadPace.
  bool is_slow(Clock::time_point since) const;
  /// Another call goes on with it.
  void resume();

  /// Adds the bytes at `offset`, which must equal committed(). The caller holds no lock. Errors, of
  /// which the first leaves it whole: as UploadShares::Slot::hold; kOutOfRange (another offset),
  /// kAborted (dropped meanwhile), as MeshBlobReader::append and BlobWriter::append.
  Status append(std::uint64_t offset, std::span<const std::byte> bytes);

  /// Makes the mesh, with this builder of its tree, after all bytes have arrived; with a writer, it
  /// is then on disk. Errors:
  /// kDataLoss (the bytes do not match the digest), kAborted, as MeshBlobReader::finish and
  /// BlobWriter::finish.
  Result<std::shared_ptr<const scenegraph::model::Mesh>> finish(
      const accel::mesh::TreeBuilder& builder = {});

  /// It is no longer in progress: its slot and its bytes are given back.
  void leave() { slot_->release(); }

  /// Frees the content, unless a thread uses it now. Returns whether it was freed.
  bool drop();

 private:
  struct Content {
    Content(std::uint64_t size, std::unique_ptr<store::BlobWriter> to)
        : reader(size), writer(std::move(to)) {}
    MeshBlobReader reader;
    std::unique_ptr<store::BlobWriter> writer;  // null: only in memory
    Sha256 sum;
  };

  const BlobDigest digest_;
  const std::unique_ptr<UploadShares::Slot> slot_;
  std::atomic<std::uint64_t> committed_{0};
  std::atomic<Clock::time_point> last_progress_{Clock::now()};
  std::atomic<Clock::time_point> begun_{Clock::now()};  // or resumed
  std::atomic<std::uint64_t> begun_at_{0};              // bytes
  std::uint64_t progress_ = 0;                          // committed bytes at last_progress_
  std::mutex mutex_;                                    // held while content_ is used
  std::optional<Content> content_;                      // empty once dropped
};

}  // namespace sightline::server::blobs

// Copies of blobs on this machine, of those that are stored in PostgreSQL.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <span>

#include "proto/result.h"
#include "server/blobs/digest.h"
#include "server/net/descriptor.h"
#include "server/store/blob_files.h"
#include "server/store/file_system.h"
#include "server/store/limits.h"

namespace sightline::server::store::postgres {

/// When it holds more than StoreLimits::cache_bytes, the least recently used go. What it loses is
/// fetched again: nothing waits for its disk. A temporary directory ends with the object; that of a
/// process that was killed serves the next one. Threads: any.
class MeshCache {
 public:
  /// Uses a directory alone, which is made if it is missing; its parent exists. An empty path: one
  /// in the directory of temporary files that no living process uses, or a new one. `files`
  /// outlives this object. Errors: kFailedPrecondition (DATA_DIR_IN_USE; CACHE_DIR: there
  /// is none that can be used), those of FileSystem.
  static Result<std::unique_ptr<MeshCache>> open(FileSystem& files,
                                                 const std::filesystem::path& directory,
                                                 const StoreLimits& limits);
  ~MeshCache();
  MeshCache(const MeshCache&) = delete;
  MeshCache& operator=(const MeshCache&) = delete;

  /// The blob, verified by the first call; null if it is not here.
  std::unique_ptr<MappedFile> find(const blobs::BlobDigest& digest);

  /// A file that is being written: it is gone with this object, unless keep() was called.
  class Copy {
   public:
    explicit Copy(MeshCache& cache, BlobFiles::Fresh fresh)
        : cache_(cache), fresh_(std::move(fresh)) {}
    ~Copy() { cache_.blobs_.abandon(fresh_); }
    Copy(const Copy&) = delete;
    Copy& operator=(const Copy&) = delete;

    Status append(std::span<const std::byte> bytes);
    /// Keeps the bytes that were appended, and maps them. Call it once, as the last. Errors:
    /// kDataLoss (DIGEST_MISMATCH), those of FileSystem.
    Result<std::unique_ptr<MappedFile>> keep(const blobs::BlobDigest& digest);

   private:
    MeshCache& cache_;
    BlobFiles::Fresh fresh_;
    blobs::Sha256 sum_;
    std::uint64_t size_ = 0;
  };
  /// Errors: kResourceExhausted (DISK_FULL: no space for `bytes` more), those of FileSystem.
  Result<std::unique_ptr<Copy>> create(std::uint64_t bytes);

  void remove(const blobs::BlobDigest& digest);

  std::uint64_t bytes() const;
  std::uint64_t bytes_free() const;

 private:
  struct Entry {
    std::uint64_t used = 0;  // larger: later
    bool verified = false;
  };

  MeshCache(FileSystem& files, std::filesystem::path directory, net::Descriptor lock,
            bool is_temporary, const StoreLimits& limits);
  Status count();
  void add(const blobs::BlobDigest& digest);
  void drop_oldest();

  FileSystem& files_;
  const std::filesystem::path directory_;
  const net::Descriptor lock_;
  const bool is_temporary_;
  const StoreLimits limits_;
  BlobFiles blobs_;
  mutable std::mutex mutex_;  // protects the rest
  std::map<blobs::BlobDigest, Entry> entries_;
  std::uint64_t bytes_ = 0;
  std::uint64_t uses_ = 0;
};

}  // namespace sightline::server::store::postgres

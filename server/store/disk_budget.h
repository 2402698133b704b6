// Whether the disk has space for what is to be written.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>

#include "proto/result.h"
#include "server/store/file_system.h"
#include "server/store/limits.h"

namespace sightline::server::store {

/// Counts what a directory holds and what is about to be written to it. Threads: any.
class DiskBudget {
 public:
  /// All arguments outlive this object.
  DiskBudget(FileSystem& files, const std::filesystem::path& directory, const StoreLimits& limits)
      : files_(files), directory_(directory), limits_(limits) {}

  /// Errors: kResourceExhausted (TOO_MANY_BYTES beyond StoreLimits::disk_bytes; DISK_FULL below
  /// StoreLimits::min_free_disk), naming the use and the limit.
  Status admit(std::uint64_t bytes) const;

  void set_database(std::uint64_t bytes) { database_ = bytes; }
  /// Counts a stored blob.
  void add_blob(std::uint64_t bytes) { blobs_ += bytes; }
  void remove_blob(std::uint64_t bytes) { blobs_ -= bytes; }
  /// Reserves the bytes of a blob that will be written.
  void reserve(std::uint64_t bytes) { reserved_ += bytes; }
  /// Counts bytes as written that were reserved.
  void wrote(std::uint64_t bytes) {
    fresh_ += bytes;
    reserved_ -= bytes;
  }
  /// The blob is stored or abandoned: stops counting what was written of it, and what was not.
  void release(std::uint64_t written, std::uint64_t unwritten) {
    fresh_ -= written;
    reserved_ -= unwritten;
  }

  std::uint64_t used() const { return database_ + blobs_ + fresh_; }
  std::uint64_t free() const;

 private:
  FileSystem& files_;
  const std::filesystem::path& directory_;
  const StoreLimits& limits_;
  std::atomic<std::uint64_t> database_{0};
  std::atomic<std::uint64_t> blobs_{0};
  std::atomic<std::uint64_t> fresh_{0};     // written bytes of blobs that are not stored yet
  std::atomic<std::uint64_t> reserved_{0};  // bytes of these blobs that are not written yet
};

}  // namespace sightline::server::store

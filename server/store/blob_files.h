// Blobs as files named by their digest.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/blobs/digest.h"
#include "server/net/descriptor.h"
#include "server/store/file_system.h"

namespace sightline::server::store {

/// blobs/ab/abcd...: the SHA-256 in hex; blobs/tmp: files that are being written. Errors of all:
/// those of FileSystem. Threads: any.
class BlobFiles {
 public:
  using Path = std::filesystem::path;

  /// A file that is being written. It has no name that counts before publish().
  struct Fresh {
    Path path;
    net::Descriptor file;
  };

  /// `files` outlives this object. `directory`: the store's.
  BlobFiles(FileSystem& files, const Path& directory) : files_(files), root_(directory / "blobs") {}

  /// Makes the directories that are missing, and removes files of dead processes.
  Status prepare();

  Path path_of(const blobs::BlobDigest& digest) const;

  Result<Fresh> create();
  Status write(const Fresh& fresh, std::span<const std::byte> bytes);
  /// Brings the file to the disk, gives it its name and brings the name to the disk.
  Status publish(Fresh& fresh, const blobs::BlobDigest& digest);
  /// Gives the file its name. It may be lost with the power.
  Status name(Fresh& fresh, const blobs::BlobDigest& digest);
  /// Removes a file that will not be published.
  void abandon(Fresh& fresh);

  /// Errors: also kDataLoss (BLOB_CORRUPT: missing, or of another size).
  Result<std::unique_ptr<MappedFile>> map(const blobs::BlobDigest& digest) const;
  Status remove(const blobs::BlobDigest& digest);
  /// All files with a name that counts.
  Result<std::vector<FileEntry>> list() const;
  /// Files that are being written, or were by a dead process.
  Result<std::vector<FileEntry>> list_fresh() const { return files_.list(fresh_directory()); }

 private:
  Path fresh_directory() const { return root_ / "tmp"; }

  FileSystem& files_;
  const Path root_;
  std::atomic<std::uint64_t> next_{0};
};

/// The error kDataLoss (BLOB_CORRUPT): `what` is wrong with the file.
Error corrupt_blob(const std::filesystem::path& file, const blobs::BlobDigest& digest,
                   std::string_view what);

/// Whether the bytes are those that the digest names.
bool matches(std::span<const std::byte> bytes, const blobs::BlobDigest& digest);

}  // namespace sightline::server::store

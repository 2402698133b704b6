// The embedded form of the store: SQLite for scenes and updates, files for blobs.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/store/data_directory.h"
#include "server/store/row_store.h"

namespace sightline::server::store {

/// Keeps everything in one directory, which it alone uses. The members are documented in store.h.
class SqliteStore final : public RowStore {
 public:
  /// Opens the directory, or makes it; its parent exists. `files` outlives the store. Errors: as
  /// StoreLimits::check(), DataDirectory::open() and DataDirectory::open_database().
  static Result<std::unique_ptr<SqliteStore>> open(const std::filesystem::path& directory,
                                                   const StoreLimits& limits = {},
                                                   FileSystem& files = local_files());
  /// Commits what is queued.
  ~SqliteStore() override;

  Result<std::unique_ptr<BlobWriter>> write_blob(const blobs::BlobDigest& digest) override;
  std::vector<bool> has_blobs(std::span<const blobs::BlobDigest> digests) override;
  Result<std::shared_ptr<const BlobBytes>> blob(const blobs::BlobDigest& digest) override;
  Result<std::uint64_t> sweep(std::chrono::steady_clock::duration grace,
                              const std::function<bool(const blobs::BlobDigest&)>& in_use) override;

  StoreFigures figures() const override;
  Status writable() override;

 private:
  struct Parts;
  explicit SqliteStore(std::unique_ptr<Parts> parts);

  Status admit(std::uint64_t bytes) override;
  void rows_dropped() override;

  std::unique_ptr<Parts> parts_;
};

}  // namespace sightline::server::store

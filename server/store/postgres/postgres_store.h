// The store of several processes: everything in PostgreSQL, with copies of meshes on this machine.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "proto/result.h"
#include "server/store/file_system.h"
#include "server/store/row_store.h"

namespace sightline::server::store::postgres {

/// The members are documented in store.h. While a commit waits for a server that tells its outcome,
/// append() returns kUnavailable.
class PostgresStore final : public RowStore {
 public:
  /// `uri`: as Address::parse(). `cache`: as MeshCache::open(). `files` outlives the store. Errors:
  /// as these, StoreLimits::check() and prepare_tables().
  static Result<std::unique_ptr<PostgresStore>> open(const std::string& uri,
                                                     const std::filesystem::path& cache,
                                                     const StoreLimits& limits = {},
                                                     FileSystem& files = local_files());
  /// Commits what is queued.
  ~PostgresStore() override;

  Status append(Batch batch, Done done) override;

  Result<std::unique_ptr<BlobWriter>> write_blob(const blobs::BlobDigest& digest) override;
  std::vector<bool> has_blobs(std::span<const blobs::BlobDigest> digests) override;
  Result<std::shared_ptr<const BlobBytes>> blob(const blobs::BlobDigest& digest) override;
  Result<std::uint64_t> sweep(std::chrono::steady_clock::duration grace,
                              const std::function<bool(const blobs::BlobDigest&)>& in_use) override;

  /// Bytes on disk and free are those of this machine, where copies of meshes are.
  StoreFigures figures() const override;
  Status writable() override;
  bool shared() const override { return true; }
  void watch(const Changed& changed) override;
  void unwatch() override;

 private:
  struct Parts;
  explicit PostgresStore(std::unique_ptr<Parts> parts);

  /// It is the server that says when its disk is full.
  Status admit(std::uint64_t /*bytes*/) override { return {}; }
  void rows_dropped() override;

  std::unique_ptr<Parts> parts_;
};

}  // namespace sightline::server::store::postgres

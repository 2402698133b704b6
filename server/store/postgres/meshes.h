// Blobs in PostgreSQL, with copies on this machine.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/blobs/digest.h"
#include "server/store/blob_rows.h"
#include "server/store/postgres/mesh_cache.h"
#include "server/store/postgres/pool.h"
#include "server/store/store.h"
#include "server/store/writer.h"

namespace sightline::server::store::postgres {

/// The members are documented in store.h. Threads: any, for every member.
class Meshes {
 public:
  /// All arguments outlive this object. `name`: this process's, for leases.
  Meshes(Pool& pool, Writer& writer, MeshCache& cache, std::string name)
      : pool_(pool), writer_(writer), cache_(cache), name_(std::move(name)) {}

  Result<std::unique_ptr<BlobWriter>> write(const blobs::BlobDigest& digest);
  /// Asks with one statement for all. It writes only the rows of blobs that were not asked for
  /// lately.
  std::vector<bool> has(std::span<const blobs::BlobDigest> digests);
  Result<std::shared_ptr<const BlobBytes>> get(const blobs::BlobDigest& digest);
  /// One process sweeps at a time: another one's call removes nothing.
  Result<std::uint64_t> sweep(std::chrono::steady_clock::duration grace,
                              const std::function<bool(const blobs::BlobDigest&)>& in_use);
  /// The totals; 0 if they cannot be read.
  BlobTotals totals();

 private:
  class Writing;

  Status upload(const blobs::BlobDigest& digest, std::span<const std::byte> bytes);
  Status upload_large(const blobs::BlobDigest& digest, std::span<const std::byte> bytes);
  Result<std::int64_t> write_content(std::span<const std::byte> bytes);
  Result<std::unique_ptr<MappedFile>> fetch(const blobs::BlobDigest& digest);
  Status copy(const blobs::BlobDigest& digest, std::int64_t content, MeshCache::Copy& copy);
  /// Begins a sweep: returns the time by the server's clock; nothing if another process sweeps.
  Result<std::optional<std::int64_t>> begin_sweep();
  void end_sweep();
  Result<std::uint64_t> remove_all(std::span<const BlobRow> rows,
                                   std::chrono::system_clock::time_point before);
  Result<std::uint64_t> remove_some(std::span<const BlobRow> rows,
                                    std::chrono::system_clock::time_point before);
  void remember_corrupt(const blobs::BlobDigest& digest, bool corrupt);

  Pool& pool_;
  Writer& writer_;
  MeshCache& cache_;
  const std::string name_;
  std::mutex mutex_;  // protects the rest
  std::set<blobs::BlobDigest> corrupt_;
};

}  // namespace sightline::server::store::postgres

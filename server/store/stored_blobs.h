// Blobs of an embedded store: files, and the rows that say which of them count.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <span>
#include <vector>

#include "proto/result.h"
#include "server/blobs/digest.h"
#include "server/store/blob_files.h"
#include "server/store/blob_rows.h"
#include "server/store/disk_budget.h"
#include "server/store/reader.h"
#include "server/store/store.h"
#include "server/store/writer.h"

namespace sightline::server::store {

/// The members are documented in store.h. Threads: any, for every member.
class StoredBlobs {
 public:
  /// All arguments outlive this object.
  StoredBlobs(BlobFiles& files, Reader& reader, Writer& writer, DiskBudget& budget)
      : files_(files), reader_(reader), writer_(writer), budget_(budget) {}

  /// Counts what is stored. Call it first.
  Status count();

  Result<std::unique_ptr<BlobWriter>> write(const blobs::BlobDigest& digest);
  std::vector<bool> has(std::span<const blobs::BlobDigest> digests);
  Result<std::shared_ptr<const BlobBytes>> get(const blobs::BlobDigest& digest);
  Result<std::uint64_t> sweep(std::chrono::steady_clock::duration grace,
                              const std::function<bool(const blobs::BlobDigest&)>& in_use);

  BlobTotals totals() const;

 private:
  class Writing;
  using Clock = std::chrono::steady_clock;
  enum class State : std::uint8_t { kVerified, kCorrupt };

  Status store(BlobFiles::Fresh& fresh, const blobs::BlobDigest& digest);
  void remember(const blobs::BlobDigest& digest, State state);
  void add(const blobs::BlobDigest& digest);
  std::vector<bool> find(std::span<const blobs::BlobDigest> digests);
  bool is_recent(const blobs::BlobDigest& digest, Clock::time_point since) const;
  Status remove_rows(std::span<const BlobRow> rows, Clock::time_point since,
                     std::vector<blobs::BlobDigest>& removed);
  Result<std::uint64_t> remove_some(std::span<const BlobRow> rows, Clock::time_point since);

  BlobFiles& files_;
  Reader& reader_;
  Writer& writer_;
  DiskBudget& budget_;
  const Clock::time_point opened_ = Clock::now();
  // It is held shared from the publishing of a file to its row, and by those who ask for a blob;
  // alone from the removal of a row to that of its file. So no file is removed that was stored anew
  // or asked for.
  std::shared_mutex removing_;
  mutable std::mutex mutex_;  // protects the rest
  std::map<blobs::BlobDigest, State> states_;
  std::map<blobs::BlobDigest, Clock::time_point> asked_;
  BlobTotals totals_;
};

}  // namespace sightline::server::store

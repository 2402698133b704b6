// The table of blobs, and what names them.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/blobs/digest.h"
#include "server/store/database.h"

namespace sightline::server::store {

/// A stored blob.
struct BlobRow {
  std::int64_t id = 0;
  blobs::BlobDigest digest;
};

struct BlobTotals {
  std::uint64_t count = 0;
  std::uint64_t bytes = 0;
};

/// The sum of the digests, in any order; each counts once.
std::uint64_t sum_of_blobs(std::span<const blobs::BlobDigest> blobs);

/// Errors of all: as Database.

/// Adds the row of a blob. One that is there already stays.
Status insert_blob(Database& database, const blobs::BlobDigest& digest,
                   std::chrono::system_clock::time_point now);
Result<std::optional<std::int64_t>> find_blob(Database& database, const blobs::BlobDigest& digest);
Result<std::vector<BlobRow>> all_blobs(Database& database);
Result<BlobTotals> blob_totals(Database& database);
/// The blobs that no batch and no snapshot names, stored before `before`.
Result<std::vector<BlobRow>> unnamed_blobs(Database& database,
                                           std::chrono::system_clock::time_point before);
/// The blobs that the scene's batches after `base` and its snapshot of `base` name.
Result<std::vector<blobs::BlobDigest>> blobs_named_by(Database& database, std::int64_t scene,
                                                      std::uint64_t base);
/// Deletes the row unless something names the blob. Returns whether it was deleted.
Result<bool> delete_unnamed(Database& database, std::int64_t blob);
/// The sum of the blobs that the rows of a batch, or of a snapshot, name.
Result<std::uint64_t> sum_named_by_batch(Database& database, std::int64_t batch);
Result<std::uint64_t> sum_named_by_snapshot(Database& database, std::int64_t snapshot);
/// Names of the scenes whose log or snapshots name the blob.
Result<std::vector<std::string>> scenes_of_blob(Database& database, std::int64_t blob);
/// The id of a blob that is about to be named. Errors: also kFailedPrecondition (BLOB_NOT_STORED).
Result<std::int64_t> need_blob(Database& database, const blobs::BlobDigest& digest);

}  // namespace sightline::server::store

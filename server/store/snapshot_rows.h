// The tables of snapshots.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "proto/result.h"
#include "server/blobs/digest.h"
#include "server/store/database.h"
#include "server/store/store.h"

namespace sightline::server::store {

/// Errors of all: as Database.

/// The row of a snapshot that is being written. An unfinished one of the revision becomes garbage.
/// Errors: also those of Store::put_snapshot().
Result<std::int64_t> begin_snapshot(Database& database, SceneId scene, std::uint64_t revision);
/// Errors: also kFailedPrecondition (BLOB_NOT_STORED).
Status name_blobs(Database& database, std::int64_t snapshot,
                  std::span<const blobs::BlobDigest> blobs);
Status insert_chunk(Database& database, std::int64_t snapshot, std::uint64_t number,
                    std::string_view data);
/// Errors: also kNotFound (the scene was removed meanwhile), kOutOfRange, kAborted
/// (SNAPSHOT_SUPERSEDED: begin_snapshot() was called again for the revision).
Status complete_snapshot(Database& database, std::int64_t snapshot);
/// Its rows become garbage.
Status abandon_snapshot(Database& database, std::int64_t snapshot);
/// The same for all snapshots whose writers are dead.
Status abandon_unfinished(Database& database);

/// As Store::read_snapshot().
Result<std::string> read_chunk(Database& database, SceneId scene, std::uint64_t revision,
                               std::uint64_t number);
/// As Store::drop_before().
Status move_base(Database& database, SceneId scene, std::uint64_t revision);

}  // namespace sightline::server::store

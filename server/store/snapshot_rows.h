// The tables of snapshots.
#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/blobs/digest.h"
#include "server/store/database.h"
#include "server/store/seal.h"
#include "server/store/store.h"

namespace sightline::server::store {

enum class SnapshotState : std::uint8_t { kBeingWritten = 0, kComplete = 1, kGarbage = 2 };

/// All columns of a snapshot's row.
struct SnapshotRow {
  std::int64_t id = 0;
  SceneKey scene;
  std::uint64_t revision = 0;
  SnapshotState state = SnapshotState::kBeingWritten;
  std::uint64_t chunks = 0;  ///< The chunks of a complete snapshot.
  std::uint64_t named = 0;   ///< Sum of the blobs that it names: see sum_of_blobs().

  std::int64_t seal() const;
};

/// The seal of a chunk of a snapshot, whose bytes have this checksum.
std::int64_t seal_chunk(const SceneKey& scene, std::uint64_t revision, std::uint64_t number,
                        std::int64_t checksum);

/// Errors of all: as Database.

/// Adds a row, and gives it its number. False: there is one of this revision.
Result<bool> insert_row(Database& database, SnapshotRow& row);
/// The row of a snapshot that is being written. An unfinished one of the revision becomes garbage.
/// Errors: also those of Store::put_snapshot().
Result<SnapshotRow> begin_snapshot(Database& database, SceneId scene, std::uint64_t revision,
                                   std::span<const blobs::BlobDigest> blobs);
/// Errors: also kFailedPrecondition (BLOB_NOT_STORED).
Status name_blobs(Database& database, std::int64_t snapshot,
                  std::span<const blobs::BlobDigest> blobs);
Status insert_chunk(Database& database, const SnapshotRow& snapshot, std::uint64_t number,
                    std::string_view data);
/// Errors: also kNotFound (the scene was removed meanwhile), kOutOfRange, kAborted
/// (SNAPSHOT_SUPERSEDED: begin_snapshot() was called again for the revision).
Status complete_snapshot(Database& database, const SnapshotRow& snapshot, std::uint64_t chunks);
/// Completes the base of a scene that is restored. A base of revision 0 becomes garbage. Errors:
/// also kAborted.
Status publish_base(Database& database, SnapshotRow base, std::uint64_t chunks);
/// Makes the snapshot's rows garbage.
Status abandon_snapshot(Database& database, const SnapshotRow& snapshot);
/// Abandons all snapshots whose writers are dead.
Status abandon_unfinished(Database& database);
/// Abandons unfinished snapshots that were begun before a time, in milliseconds since 1970. Only
/// for tables that have that time.
Status abandon_begun_before(Database& database, std::int64_t time);

/// The complete snapshots by revision. A row that does not match its seal is left out.
Result<std::vector<SnapshotRow>> complete_snapshots(Database& database, const SceneKey& scene);
/// Reads a chunk as Store::read_snapshot() does.
Result<std::string> read_chunk(Database& database, SceneId scene, std::uint64_t revision,
                               std::uint64_t number);
/// Moves the base as Store::drop_before() does.
Status move_base(Database& database, SceneId scene, std::uint64_t revision);

}  // namespace sightline::server::store

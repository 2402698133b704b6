// The tables of snapshots.
#include "server/store/snapshot_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "server/store/blob_rows.h"
#include "server/store/checksum.h"
#include "server/store/errors.h"
#include "server/store/log_rows.h"
#include "server/store/scene_rows.h"

namespace sightline::server::store {
namespace {

Error no_snapshot(SceneId scene, std::uint64_t revision, Code code) {
  return {
      code,
      fmt::format("the scene with the number {} has no snapshot of revision {}", scene, revision),
      "NO_SNAPSHOT"};
}

Error damaged_snapshot(const Database& database, SceneId scene, std::uint64_t revision) {
  return database.corrupt(
      fmt::format("the snapshot of revision {} of the scene with the number {} "
                  "does not match its checksum",
                  revision, scene));
}

/// The snapshots of a scene whose rows match their seals.
Result<std::vector<SnapshotRow>> sound_rows(Database& database, const SceneKey& scene) {
  std::vector<SnapshotRow> rows;
  const Status read = database.each(
      "SELECT id, revision, state, chunks, named, seal FROM snapshot WHERE scene = ? "
      "ORDER BY revision, id",
      [&](const Row& row) {
        const SnapshotRow snapshot{
            row.number(0),          scene,
            row.unsigned_number(1), static_cast<SnapshotState>(row.number(2)),
            row.unsigned_number(3), row.unsigned_number(4)};
        if (snapshot.seal() == row.number(5)) rows.push_back(snapshot);
        return Status();
      },
      scene.id);
  if (!read) return read.error();
  return rows;
}

Result<SnapshotRow> find_snapshot(Database& database, const SceneRow& scene, std::uint64_t revision,
                                  Code missing) {
  const auto rows = complete_snapshots(database, scene.key);
  if (!rows) return rows.error();
  const auto found = std::ranges::find(*rows, revision, &SnapshotRow::revision);
  if (found != rows->end()) return *found;
  if (revision > 0 && revision == scene.base)
    return damaged_snapshot(database, scene.key.id, revision);
  return no_snapshot(scene.key.id, revision, missing);
}

/// Writes what changes. False: the row had another state than `before`.
Result<bool> write_state(Database& database, const SnapshotRow& row, SnapshotState before) {
  const Status done = database.execute(
      "UPDATE snapshot SET state = ?, chunks = ?, seal = ? WHERE id = ? AND state = ?",
      static_cast<std::int64_t>(row.state), row.chunks, row.seal(), row.id,
      static_cast<std::int64_t>(before));
  if (!done) return done.error();
  return database.changes() > 0;
}

Status make_garbage(Database& database, SnapshotRow row) {
  const SnapshotState before = row.state;
  row.state = SnapshotState::kGarbage;
  const auto written = write_state(database, row, before);
  return written ? Status() : Status(written.error());
}

Status check_range(const SceneRow& scene, std::uint64_t revision) {
  if (revision >= 1 && revision >= scene.base && revision <= scene.revision) return {};
  return Error{Code::kOutOfRange,
               fmt::format("a snapshot of revision {} cannot be stored; {} to {} can", revision,
                           std::max<std::uint64_t>(scene.base, 1), scene.revision),
               "REVISION_NOT_KEPT"};
}

/// Numbers of scenes and of snapshots.
using Unfinished = std::vector<std::pair<SceneId, std::int64_t>>;

/// Rows that are damaged stay: they may be those of a snapshot that is complete.
Status abandon_all(Database& database, const Unfinished& unfinished) {
  for (const auto& [id, snapshot] : unfinished) {
    const auto scene = lock_scene(database, id);
    if (!scene && scene.error().code == Code::kDataLoss) continue;
    if (!scene) return scene.error();
    const auto rows = sound_rows(database, scene->key);
    if (!rows) return rows.error();
    const auto row = std::ranges::find(*rows, snapshot, &SnapshotRow::id);
    if (row == rows->end() || row->state != SnapshotState::kBeingWritten) continue;
    if (Status done = abandon_snapshot(database, *row); !done) return done;
  }
  return {};
}

template <class... Values>
Status abandon(Database& database, const char* query, const Values&... values) {
  Unfinished unfinished;
  const Status read = database.each(
      query,
      [&](const Row& row) {
        unfinished.emplace_back(row.number(0), row.number(1));
        return Status();
      },
      values...);
  return read ? abandon_all(database, unfinished) : read;
}

}  // namespace

std::int64_t SnapshotRow::seal() const {
  return Seal(RowKind::kSnapshot, scene)
      .add(id)
      .add(revision)
      .add(static_cast<std::uint64_t>(state))
      .add(chunks)
      .add(named)
      .value();
}

std::int64_t seal_chunk(const SceneKey& scene, std::uint64_t revision, std::uint64_t number,
                        std::int64_t checksum) {
  return Seal(RowKind::kChunk, scene).add(revision).add(number).add(checksum).value();
}

/// The row is written in two steps, as its number is part of the seal.
Result<bool> insert_row(Database& database, SnapshotRow& row) {
  const auto id = database.number(
      "INSERT INTO snapshot(scene, revision, state, named) VALUES(?, ?, ?, ?) "
      "ON CONFLICT DO NOTHING RETURNING id",
      row.scene.id, row.revision, static_cast<std::int64_t>(row.state), row.named);
  if (!id) return id.error();
  if (!*id) return false;
  row.id = **id;
  return write_state(database, row, row.state);
}

Result<SnapshotRow> begin_snapshot(Database& database, SceneId scene, std::uint64_t revision,
                                   std::span<const blobs::BlobDigest> blobs) {
  const auto row = read_scene(database, scene);
  if (!row) return row.error();
  if (const Status good = check_range(*row, revision); !good) return good.error();
  const auto others = sound_rows(database, row->key);
  if (!others) return others.error();
  SceneRow holder = *row;
  for (const SnapshotRow& other : *others) {
    if (other.revision != revision || other.state != SnapshotState::kBeingWritten) continue;
    if (const Status done = make_garbage(database, other); !done) return done.error();
    holder.garbage = true;
  }
  if (holder.garbage && !row->garbage) {
    if (const Status done = write_scene(database, holder); !done) return done.error();
  }
  SnapshotRow snapshot{.scene = row->key, .revision = revision, .named = sum_of_blobs(blobs)};
  const auto inserted = insert_row(database, snapshot);
  if (!inserted) return inserted.error();
  if (*inserted) return snapshot;
  return Error{Code::kAlreadyExists, fmt::format("there is a snapshot of revision {}", revision),
               "SNAPSHOT_EXISTS"};
}

Status name_blobs(Database& database, std::int64_t snapshot,
                  std::span<const blobs::BlobDigest> blobs) {
  for (const blobs::BlobDigest& digest : blobs) {
    const auto blob = need_blob(database, digest);
    if (!blob) return blob.error();
    if (Status done = database.execute(
            "INSERT INTO snapshot_blob VALUES(?, ?) ON CONFLICT DO NOTHING", snapshot, *blob);
        !done)
      return done;
  }
  return {};
}

Status insert_chunk(Database& database, const SnapshotRow& snapshot, std::uint64_t number,
                    std::string_view data) {
  const auto bytes = as_bytes(data);
  const std::int64_t checksum = checksum_of(bytes);
  return database.execute(
      "INSERT INTO snapshot_chunk(snapshot, number, checksum, data, seal) VALUES(?, ?, ?, ?, ?)",
      snapshot.id, number, checksum, bytes,
      seal_chunk(snapshot.scene, snapshot.revision, number, checksum));
}

Status complete_snapshot(Database& database, const SnapshotRow& snapshot, std::uint64_t chunks) {
  const auto row = read_scene(database, snapshot.scene.id);
  if (!row) return row.error();
  if (Status good = check_range(*row, snapshot.revision); !good) return good;
  return publish_base(database, snapshot, chunks);
}

Status publish_base(Database& database, SnapshotRow base, std::uint64_t chunks) {
  base.chunks = chunks;
  base.state = base.revision == 0 ? SnapshotState::kGarbage : SnapshotState::kComplete;
  const auto written = write_state(database, base, SnapshotState::kBeingWritten);
  if (!written) return written.error();
  if (*written) return {};
  return Error{Code::kAborted,
               fmt::format("another call stores the snapshot of revision {}", base.revision),
               "SNAPSHOT_SUPERSEDED"};
}

/// The scene is marked also if the snapshot is garbage already.
Status abandon_snapshot(Database& database, const SnapshotRow& snapshot) {
  auto scene = lock_scene(database, snapshot.scene.id);
  if (!scene) return scene.error();
  scene->garbage = true;
  if (Status done = write_scene(database, *scene); !done) return done;
  return make_garbage(database, snapshot);
}

Status abandon_unfinished(Database& database) {
  return abandon(database, "SELECT scene, id FROM snapshot WHERE state = 0");
}

Status abandon_begun_before(Database& database, std::int64_t time) {
  return abandon(database,
                 "SELECT scene, id FROM snapshot WHERE state = 0 AND begun < ? ORDER BY scene",
                 time);
}

Result<std::vector<SnapshotRow>> complete_snapshots(Database& database, const SceneKey& scene) {
  auto rows = sound_rows(database, scene);
  if (!rows) return rows;
  std::erase_if(*rows,
                [](const SnapshotRow& row) { return row.state != SnapshotState::kComplete; });
  return rows;
}

Result<std::string> read_chunk(Database& database, SceneId scene, std::uint64_t revision,
                               std::uint64_t number) {
  const auto row = read_scene(database, scene);
  if (!row) return row.error();
  const auto snapshot = find_snapshot(database, *row, revision, Code::kNotFound);
  if (!snapshot) return snapshot.error();
  if (number >= snapshot->chunks) return std::string();
  std::optional<std::string> data;
  const Status read = database.each(
      "SELECT checksum, data, seal FROM snapshot_chunk WHERE snapshot = ? AND number = ?",
      [&](const Row& found) -> Status {
        const std::int64_t checksum = checksum_of(found.bytes(1));
        if (checksum != found.number(0) ||
            seal_chunk(row->key, revision, number, checksum) != found.number(2))
          return damaged_snapshot(database, scene, revision);
        data = found.copy_of_bytes(1);
        return {};
      },
      snapshot->id, number);
  if (!read) return read.error();
  if (!data) return damaged_snapshot(database, scene, revision);
  return std::move(*data);
}

Status move_base(Database& database, SceneId scene, std::uint64_t revision) {
  auto row = read_scene(database, scene);
  if (!row) return row.error();
  const auto snapshot = find_snapshot(database, *row, revision, Code::kFailedPrecondition);
  if (!snapshot) return snapshot.error();
  if (revision == row->base) return {};
  const auto logged = logged_at(database, row->key, revision);
  if (!logged) return logged.error();
  row->base = revision;
  row->base_logged = *logged;
  row->garbage = true;
  Status done = write_scene(database, *row);
  const auto older = complete_snapshots(database, row->key);
  if (!older) return older.error();
  for (const SnapshotRow& old : *older) {
    if (!done || old.revision >= revision) break;
    done = make_garbage(database, old);
  }
  return done;
}

}  // namespace sightline::server::store

// The tables of snapshots. States: 0 being written, 1 complete, 2 garbage.
#include "server/store/snapshot_rows.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/store/blob_rows.h"
#include "server/store/checksum.h"
#include "server/store/errors.h"
#include "server/store/scene_rows.h"

namespace sightline::server::store {
namespace {

Error no_snapshot(SceneId scene, std::uint64_t revision, Code code) {
  return {
      code,
      fmt::format("the scene with the number {} has no snapshot of revision {}", scene, revision),
      "NO_SNAPSHOT"};
}

Result<std::int64_t> find_snapshot(Database& database, SceneId scene, std::uint64_t revision,
                                   Code missing) {
  const auto id = database.number(
      "SELECT id FROM snapshot WHERE scene = ? AND revision = ? AND state = 1", scene, revision);
  if (!id) return id.error();
  if (!*id) return no_snapshot(scene, revision, missing);
  return **id;
}

Status check_range(const SceneRecord& scene, std::uint64_t revision) {
  if (revision >= 1 && revision >= scene.base && revision <= scene.revision) return {};
  return Error{Code::kOutOfRange,
               fmt::format("a snapshot of revision {} cannot be stored; {} to {} can", revision,
                           std::max<std::uint64_t>(scene.base, 1), scene.revision),
               "REVISION_NOT_KEPT"};
}

}  // namespace

Result<std::int64_t> begin_snapshot(Database& database, SceneId scene, std::uint64_t revision) {
  const auto record = find_scene(database, scene);
  if (!record) return record.error();
  if (const Status good = check_range(*record, revision); !good) return good.error();
  Status done = database.execute(
      "UPDATE snapshot SET state = 2 WHERE scene = ? AND revision = ? AND state = 0", scene,
      revision);
  if (done && database.changes() > 0)
    done = database.execute("UPDATE scene SET garbage = 1 WHERE id = ?", scene);
  if (!done) return done.error();
  const auto id = database.number(
      "INSERT INTO snapshot(scene, revision, state) VALUES(?, ?, 0) ON CONFLICT DO NOTHING "
      "RETURNING id",
      scene, revision);
  if (!id) return id.error();
  if (*id) return **id;
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

Status insert_chunk(Database& database, std::int64_t snapshot, std::uint64_t number,
                    std::string_view data) {
  const auto bytes = as_bytes(data);
  return database.execute(
      "INSERT INTO snapshot_chunk(snapshot, number, checksum, data) VALUES(?, ?, ?, ?)", snapshot,
      number, checksum_of(bytes), bytes);
}

Status complete_snapshot(Database& database, std::int64_t snapshot) {
  SceneId scene = 0;
  std::uint64_t revision = 0;
  Status read = database.each(
      "SELECT scene, revision FROM snapshot WHERE id = ?",
      [&](const Row& row) {
        scene = row.number(0);
        revision = row.unsigned_number(1);
        return Status();
      },
      snapshot);
  if (!read) return read;
  const auto record = find_scene(database, scene);
  if (!record) return record.error();
  if (Status good = check_range(*record, revision); !good) return good;
  Status done =
      database.execute("UPDATE snapshot SET state = 1 WHERE id = ? AND state = 0", snapshot);
  if (!done || database.changes() > 0) return done;
  return Error{Code::kAborted,
               fmt::format("another call stores the snapshot of revision {}", revision),
               "SNAPSHOT_SUPERSEDED"};
}

Status abandon_snapshot(Database& database, std::int64_t snapshot) {
  Status done = database.execute("UPDATE snapshot SET state = 2 WHERE id = ?", snapshot);
  if (!done) return done;
  return database.execute(
      "UPDATE scene SET garbage = 1 WHERE id = (SELECT scene FROM snapshot WHERE id = ?)",
      snapshot);
}

Status abandon_unfinished(Database& database) {
  Status done = database.execute(
      "UPDATE scene SET garbage = 1 WHERE id IN (SELECT scene FROM snapshot WHERE state = 0)");
  if (!done) return done;
  return database.execute("UPDATE snapshot SET state = 2 WHERE state = 0");
}

Result<std::string> read_chunk(Database& database, SceneId scene, std::uint64_t revision,
                               std::uint64_t number) {
  const auto snapshot = find_snapshot(database, scene, revision, Code::kNotFound);
  if (!snapshot) return snapshot.error();
  std::string data;
  const Status read = database.each(
      "SELECT checksum, data FROM snapshot_chunk WHERE snapshot = ? AND number = ?",
      [&](const Row& row) -> Status {
        if (checksum_of(row.bytes(1)) != row.number(0)) {
          return database.corrupt(
              fmt::format("the snapshot of revision {} of the scene with the number {} "
                          "does not match its checksum",
                          revision, scene));
        }
        data = row.copy_of_bytes(1);
        return {};
      },
      *snapshot, number);
  if (!read) return read.error();
  return data;
}

Status move_base(Database& database, SceneId scene, std::uint64_t revision) {
  const auto record = find_scene(database, scene);
  if (!record) return record.error();
  const auto snapshot = find_snapshot(database, scene, revision, Code::kFailedPrecondition);
  if (!snapshot) return snapshot.error();
  if (revision == record->base) return {};
  Status done = database.execute(
      "UPDATE scene SET base = ?2, garbage = 1, base_logged = "
      "(SELECT logged FROM batch WHERE scene = ?1 AND revision = ?2) WHERE id = ?1",
      scene, revision);
  if (!done) return done;
  return database.execute(
      "UPDATE snapshot SET state = 2 WHERE scene = ? AND revision < ? AND state = 1", scene,
      revision);
}

}  // namespace sightline::server::store

// The table of updates.
#include "server/store/log_rows.h"

#include <fmt/format.h>

#include <optional>

#include "server/store/answer_rows.h"
#include "server/store/blob_rows.h"
#include "server/store/checksum.h"
#include "server/store/errors.h"
#include "server/store/milliseconds.h"
#include "server/store/producer_rows.h"
#include "server/store/scene_rows.h"

namespace sightline::server::store {
namespace {

Error damaged_batch(const Database& database, SceneId scene, std::uint64_t revision) {
  return database.corrupt(fmt::format(
      "revision {} of the scene with the number {} does not match its checksum", revision, scene));
}

Error missing_batch(const Database& database, SceneId scene, std::uint64_t revision) {
  return database.corrupt(
      fmt::format("revision {} of the scene with the number {} is missing", revision, scene));
}

Status check_log(const SceneRow& head, std::uint64_t bytes, const StoreLimits& limits) {
  if (head.revision - head.base >= limits.log_revisions) {
    return over_limit("log_revisions", head.revision - head.base + 1, limits.log_revisions,
                      "LOG_FULL");
  }
  if (head.logged - head.base_logged + bytes > limits.log_bytes) {
    return over_limit("log_bytes", head.logged - head.base_logged + bytes, limits.log_bytes,
                      "LOG_FULL");
  }
  return {};
}

Status insert_updates(Database& database, const Batch& batch, SceneRow& head,
                      std::chrono::system_clock::time_point now) {
  const auto bytes = as_bytes(*batch.updates);
  head.revision += 1;
  head.logged += bytes.size();
  const BatchRow row{head.key,
                     head.revision,
                     to_milliseconds(now),
                     head.logged,
                     sum_of_blobs(batch.blobs),
                     checksum_of(bytes)};
  const auto id = database.number(
      "INSERT INTO batch(scene, revision, time, logged, checksum, updates, named, seal) "
      "VALUES(?, ?, ?, ?, ?, ?, ?, ?) RETURNING id",
      batch.scene, row.revision, row.time, row.logged, row.checksum, bytes, row.named, row.seal());
  if (!id) return id.error();
  for (const blobs::BlobDigest& digest : batch.blobs) {
    const auto blob = need_blob(database, digest);
    if (!blob) return blob.error();
    Status done =
        database.execute("INSERT INTO batch_blob VALUES(?, ?) ON CONFLICT DO NOTHING", **id, *blob);
    if (!done) return done;
  }
  return {};
}

}  // namespace

std::int64_t BatchRow::seal() const {
  return Seal(RowKind::kBatch, scene)
      .add(revision)
      .add(time)
      .add(logged)
      .add(named)
      .add(checksum)
      .value();
}

Status insert_batch(Database& database, const Batch& batch, const StoreLimits& limits,
                    std::chrono::system_clock::time_point now) {
  auto head = read_scene(database, batch.scene);
  if (!head) return head.error();
  if (batch.after != nullptr && !batch.after->kept) {
    return Error{Code::kAborted,
                 fmt::format("revision {}, on which it builds, is not kept", batch.expected),
                 "REVISION_MISMATCH"};
  }
  if (head->revision != batch.expected) {
    return Error{
        Code::kAborted,
        fmt::format("the newest stored revision is {}, not {}", head->revision, batch.expected),
        "REVISION_MISMATCH"};
  }
  if (batch.updates) {
    if (Status fits = check_log(*head, batch.updates->size(), limits); !fits) return fits;
    if (Status done = insert_updates(database, batch, *head, now); !done) return done;
  }
  if (batch.answer) {
    if (Status done = insert_answer(database, *head, *batch.answer, limits); !done) return done;
  }
  for (const ProducerCommit& commit : batch.commits) {
    if (Status done = insert_commit(database, *head, commit, limits); !done) return done;
  }
  return write_scene(database, *head);
}

Result<std::vector<LoggedBatch>> read_batches(Database& database, SceneId scene,
                                              std::uint64_t after, std::uint64_t max_bytes) {
  const auto head = read_scene(database, scene);
  if (!head) return head.error();
  if (after < head->base) {
    return Error{Code::kOutOfRange,
                 fmt::format("the log begins after revision {}, so revision {} is not in it",
                             head->base, after + 1),
                 "REVISION_NOT_KEPT"};
  }
  std::vector<LoggedBatch> batches;
  std::uint64_t next = after;
  std::uint64_t bytes = 0;
  // One row at a time, so that a part ends before a row is read that does not fit.
  while (next < head->revision && (batches.empty() || bytes < max_bytes)) {
    bool found = false;
    bool fits = true;
    const Status read = database.each(
        "SELECT time, logged, named, checksum, seal, updates FROM batch "
        "WHERE scene = ? AND revision = ?",
        [&](const Row& row) -> Status {
          found = true;
          const auto updates = row.bytes(5);
          fits = batches.empty() || updates.size() <= max_bytes - bytes;
          if (!fits) return {};
          const BatchRow batch{head->key,
                               next + 1,
                               row.number(0),
                               row.unsigned_number(1),
                               row.unsigned_number(2),
                               checksum_of(updates)};
          if (batch.checksum != row.number(3) || batch.seal() != row.number(4))
            return damaged_batch(database, scene, next + 1);
          bytes += updates.size();
          batches.push_back({next + 1, from_milliseconds(batch.time), row.copy_of_bytes(5)});
          return {};
        },
        scene, next + 1);
    if (!read) return read.error();
    if (!found) return missing_batch(database, scene, next + 1);
    if (!fits) break;
    ++next;
  }
  return batches;
}

Result<std::uint64_t> logged_at(Database& database, const SceneKey& scene, std::uint64_t revision) {
  std::optional<std::uint64_t> logged;
  const Status read = database.each(
      "SELECT time, logged, named, checksum, seal FROM batch WHERE scene = ? AND revision = ?",
      [&](const Row& row) -> Status {
        const BatchRow batch{
            scene,        revision, row.number(0), row.unsigned_number(1), row.unsigned_number(2),
            row.number(3)};
        if (batch.seal() != row.number(4)) return damaged_batch(database, scene.id, revision);
        logged = batch.logged;
        return {};
      },
      scene.id, revision);
  if (!read) return read.error();
  if (!logged) return missing_batch(database, scene.id, revision);
  return *logged;
}

}  // namespace sightline::server::store

// The table of updates.
#include "server/store/log_rows.h"

#include <fmt/format.h>

#include "server/store/answer_rows.h"
#include "server/store/blob_rows.h"
#include "server/store/checksum.h"
#include "server/store/errors.h"
#include "server/store/milliseconds.h"
#include "server/store/producer_rows.h"
#include "server/store/scene_rows.h"

namespace sightline::server::store {
namespace {

struct Head {
  std::uint64_t revision = 0;
  std::uint64_t base = 0;
  std::uint64_t logged = 0;
  std::uint64_t base_logged = 0;
};

Result<Head> find_head(Database& database, SceneId scene) {
  Head head;
  bool found = false;
  const Status read = database.each(
      "SELECT revision, base, logged, base_logged FROM scene WHERE id = ? AND removed = 0",
      [&](const Row& row) {
        found = true;
        head = {row.unsigned_number(0), row.unsigned_number(1), row.unsigned_number(2),
                row.unsigned_number(3)};
        return Status();
      },
      scene);
  if (!read) return read.error();
  if (!found) return no_scene(scene);
  return head;
}

Status check_log(const Head& head, std::uint64_t bytes, const StoreLimits& limits) {
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

Status insert_updates(Database& database, const Batch& batch, const Head& head,
                      std::chrono::system_clock::time_point now) {
  const auto bytes = as_bytes(*batch.updates);
  const std::uint64_t revision = head.revision + 1;
  const std::uint64_t logged = head.logged + bytes.size();
  const auto id = database.number(
      "INSERT INTO batch(scene, revision, time, logged, checksum, updates) "
      "VALUES(?, ?, ?, ?, ?, ?) RETURNING id",
      batch.scene, revision, to_milliseconds(now), logged, checksum_of(bytes), bytes);
  if (!id) return id.error();
  Status done;
  for (std::size_t i = 0; done && i < batch.blobs.size(); ++i) {
    const auto blob = need_blob(database, batch.blobs[i]);
    if (!blob) return blob.error();
    done =
        database.execute("INSERT INTO batch_blob VALUES(?, ?) ON CONFLICT DO NOTHING", **id, *blob);
  }
  if (!done) return done;
  return database.execute("UPDATE scene SET revision = ?, logged = ? WHERE id = ?", revision,
                          logged, batch.scene);
}

}  // namespace

Status insert_batch(Database& database, const Batch& batch, const StoreLimits& limits,
                    std::chrono::system_clock::time_point now) {
  const auto head = find_head(database, batch.scene);
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
    if (Status done = insert_answer(database, batch.scene, *batch.answer, limits); !done)
      return done;
  }
  for (const ProducerCommit& commit : batch.commits) {
    if (Status done = insert_commit(database, batch.scene, commit, limits); !done) return done;
  }
  return {};
}

Result<std::vector<LoggedBatch>> read_batches(Database& database, SceneId scene,
                                              std::uint64_t after, std::uint64_t max_bytes) {
  const auto head = find_head(database, scene);
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
        "SELECT time, checksum, updates FROM batch WHERE scene = ? AND revision = ?",
        [&](const Row& row) -> Status {
          found = true;
          const auto updates = row.bytes(2);
          fits = batches.empty() || updates.size() <= max_bytes - bytes;
          if (!fits) return {};
          if (checksum_of(updates) != row.number(1)) {
            return database.corrupt(
                fmt::format("revision {} of the scene with the number "
                            "{} does not match its checksum",
                            next + 1, scene));
          }
          bytes += updates.size();
          batches.push_back({next + 1, from_milliseconds(row.number(0)), row.copy_of_bytes(2)});
          return {};
        },
        scene, next + 1);
    if (!read) return read.error();
    if (!found) {
      return database.corrupt(
          fmt::format("revision {} of the scene with the number {} is missing", next + 1, scene));
    }
    if (!fits) break;
    ++next;
  }
  return batches;
}

}  // namespace sightline::server::store

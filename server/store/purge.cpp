// Deletes rows that nothing needs any more, step by step.
#include "server/store/purge.h"

#include <array>
#include <cstdint>
#include <limits>

namespace sightline::server::store {
namespace {

/// A scene with garbage.
struct Garbage {
  std::int64_t scene = 0;
  bool removed = false;
  std::int64_t up_to = 0;  // batches of these revisions
};

constexpr const char* kFindGarbage =
    "SELECT id, removed, base FROM scene WHERE garbage = 1 LIMIT 1";
/// Where others write, too, the row is held until the transaction ends, so that nothing becomes
/// garbage while it is said that there is none.
constexpr const char* kHoldGarbage =
    "SELECT id, removed, base FROM scene WHERE garbage = 1 LIMIT 1 FOR UPDATE SKIP LOCKED";

Result<Garbage> find_garbage(Database& database) {
  Garbage garbage;
  const Status read =
      database.each(database.shared() ? kHoldGarbage : kFindGarbage, [&](const Row& row) {
        garbage.scene = row.number(0);
        garbage.removed = row.number(1) != 0;
        garbage.up_to = garbage.removed ? std::numeric_limits<std::int64_t>::max() : row.number(2);
        return Status();
      });
  if (!read) return read.error();
  return garbage;
}

/// Children before the rows that they belong to. Each statement deletes a bounded number.
constexpr std::array<const char*, 4> kGarbage{
    "DELETE FROM batch WHERE id IN "
    "(SELECT id FROM batch WHERE scene = ?1 AND revision <= ?2 ORDER BY revision LIMIT 256)",
    "DELETE FROM snapshot_chunk WHERE id IN (SELECT snapshot_chunk.id FROM snapshot_chunk "
    "JOIN snapshot ON snapshot = snapshot.id WHERE scene = ?1 AND (state = 2 OR ?3 = 1) LIMIT 8)",
    "DELETE FROM snapshot_blob WHERE (snapshot, blob) IN (SELECT snapshot, blob FROM snapshot_blob "
    "JOIN snapshot ON snapshot = snapshot.id WHERE scene = ?1 AND (state = 2 OR ?3 = 1) LIMIT "
    "1024)",
    "DELETE FROM snapshot AS s WHERE scene = ?1 AND (state = 2 OR ?3 = 1) "
    "AND NOT EXISTS (SELECT 1 FROM snapshot_chunk WHERE snapshot = s.id) "
    "AND NOT EXISTS (SELECT 1 FROM snapshot_blob WHERE snapshot = s.id)",
};
/// Only of scenes that were removed.
constexpr std::array<const char*, 3> kWriters{
    "DELETE FROM answer WHERE id IN (SELECT id FROM answer WHERE scene = ?1 LIMIT 256)",
    "DELETE FROM put WHERE (scene, producer, sequence) IN "
    "(SELECT scene, producer, sequence FROM put WHERE scene = ?1 LIMIT 256)",
    "DELETE FROM producer WHERE (scene, name) IN (SELECT scene, name FROM producer AS p "
    "WHERE scene = ?1 AND NOT EXISTS "
    "(SELECT 1 FROM put WHERE put.scene = p.scene AND put.producer = p.name) LIMIT 256)",
};

/// Returns how many rows were deleted.
Result<std::int64_t> delete_some(Database& database, const Garbage& garbage) {
  std::int64_t deleted = 0;
  const std::int64_t removed = garbage.removed ? 1 : 0;
  for (const char* query : kGarbage) {
    if (const Status done = database.execute(query, garbage.scene, garbage.up_to, removed); !done)
      return done.error();
    deleted += database.changes();
  }
  for (const char* query : kWriters) {
    if (!garbage.removed) break;
    if (const Status done = database.execute(query, garbage.scene); !done) return done.error();
    deleted += database.changes();
  }
  return deleted;
}

}  // namespace

Result<bool> purge_some(Database& database) {
  const auto garbage = find_garbage(database);
  if (!garbage) return garbage.error();
  if (garbage->scene == 0) return false;
  const auto deleted = delete_some(database, *garbage);
  if (!deleted) return deleted.error();
  if (*deleted > 0) return true;
  const Status done =
      garbage->removed
          ? database.execute("DELETE FROM scene WHERE id = ?", garbage->scene)
          : database.execute("UPDATE scene SET garbage = 0 WHERE id = ?", garbage->scene);
  if (!done) return done.error();
  return true;
}

}  // namespace sightline::server::store

// Deletes rows that nothing needs any more, step by step.
#include "server/store/purge.h"

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "server/store/scene_rows.h"

namespace sightline::server::store {
namespace {

constexpr const char* kFindGarbage =
    "SELECT id FROM scene WHERE garbage = 1 AND id > ? ORDER BY id LIMIT 1";
/// Where others write, too, the row is held until the transaction ends, so that nothing becomes
/// garbage while it is said that there is none.
constexpr const char* kHoldGarbage =
    "SELECT id FROM scene WHERE garbage = 1 AND id > ? ORDER BY id LIMIT 1 FOR UPDATE SKIP LOCKED";

/// The row of a scene with garbage; nothing if there is none. Skips damaged rows: what they call
/// garbage may be what is served.
Result<std::optional<SceneRow>> find_garbage(Database& database) {
  for (SceneId last = 0;;) {
    const auto id = database.number(database.shared() ? kHoldGarbage : kFindGarbage, last);
    if (!id) return id.error();
    if (!*id || **id <= last) return std::optional<SceneRow>();
    last = **id;
    auto row = lock_scene(database, last);
    if (row && row->garbage) return std::optional(std::move(*row));
    if (!row && row.error().code != Code::kDataLoss && row.error().code != Code::kNotFound)
      return row.error();
  }
}

/// Deletes children before the rows that they belong to. Each statement deletes a bounded number.
/// Where a damaged index leads to rows of another scene, these stay: + keeps a condition from being
/// looked up in an index.
constexpr std::array<const char*, 4> kGarbage{
    "DELETE FROM batch WHERE id IN "
    "(SELECT id FROM batch WHERE scene = ?1 AND revision <= ?2 ORDER BY revision LIMIT 256) "
    "AND +scene = ?1 AND +revision <= ?2",
    "DELETE FROM snapshot_chunk WHERE id IN (SELECT snapshot_chunk.id FROM snapshot_chunk "
    "JOIN snapshot ON snapshot = snapshot.id WHERE scene = ?1 AND (state = 2 OR ?3 = 1) LIMIT 8)",
    "DELETE FROM snapshot_blob WHERE (snapshot, blob) IN (SELECT snapshot, blob FROM snapshot_blob "
    "JOIN snapshot ON snapshot = snapshot.id WHERE scene = ?1 AND (state = 2 OR ?3 = 1) LIMIT "
    "1024)",
    "DELETE FROM snapshot AS s WHERE scene = ?1 AND (state = 2 OR ?3 = 1) "
    "AND NOT EXISTS (SELECT 1 FROM snapshot_chunk WHERE snapshot = s.id) "
    "AND NOT EXISTS (SELECT 1 FROM snapshot_blob WHERE snapshot = s.id)",
};
/// Used only for scenes that were removed.
constexpr std::array<const char*, 3> kWriters{
    "DELETE FROM answer WHERE id IN (SELECT id FROM answer WHERE scene = ?1 LIMIT 256) "
    "AND +scene = ?1",
    "DELETE FROM put WHERE (scene, producer, sequence) IN "
    "(SELECT scene, producer, sequence FROM put WHERE scene = ?1 LIMIT 256)",
    "DELETE FROM producer WHERE (scene, name) IN (SELECT scene, name FROM producer AS p "
    "WHERE scene = ?1 AND NOT EXISTS "
    "(SELECT 1 FROM put WHERE put.scene = p.scene AND put.producer = p.name) LIMIT 256)",
};

/// Returns how many rows were deleted.
Result<std::int64_t> delete_some(Database& database, const SceneRow& scene) {
  std::int64_t deleted = 0;
  const std::int64_t removed = scene.removed ? 1 : 0;
  // Batches up to this revision are garbage.
  const std::int64_t up_to = scene.removed ? std::numeric_limits<std::int64_t>::max()
                                           : static_cast<std::int64_t>(scene.base);
  for (const char* query : kGarbage) {
    if (const Status done = database.execute(query, scene.key.id, up_to, removed); !done)
      return done.error();
    deleted += database.changes();
  }
  for (const char* query : kWriters) {
    if (!scene.removed) break;
    if (const Status done = database.execute(query, scene.key.id); !done) return done.error();
    deleted += database.changes();
  }
  return deleted;
}

}  // namespace

Result<bool> purge_some(Database& database) {
  auto garbage = find_garbage(database);
  if (!garbage) return garbage.error();
  if (!*garbage) return false;
  SceneRow& scene = **garbage;
  const auto deleted = delete_some(database, scene);
  if (!deleted) return deleted.error();
  if (*deleted > 0) return true;
  scene.garbage = false;
  const Status done = scene.removed
                          ? database.execute("DELETE FROM scene WHERE id = ?", scene.key.id)
                          : write_scene(database, scene);
  if (!done) return done.error();
  return true;
}

}  // namespace sightline::server::store

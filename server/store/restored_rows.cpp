// The rows of a scene that is restored.
#include "server/store/restored_rows.h"

#include <optional>
#include <string>

#include "server/store/scene_rows.h"

namespace sightline::server::store {

Result<RestoredScene> begin_restored(Database& database, const SceneInfo& info,
                                     std::uint64_t revision) {
  const auto scene = database.number(
      "INSERT INTO scene(name, incarnation, up_axis, meters_per_unit, revision, base, removed) "
      "VALUES(?1, ?2, ?3, ?4, ?5, ?5, 1) RETURNING id",
      info.name, info.incarnation, static_cast<std::int64_t>(info.up_axis), info.meters_per_unit,
      revision);
  if (!scene) return scene.error();
  const auto snapshot =
      database.number("INSERT INTO snapshot(scene, revision, state) VALUES(?, ?, 0) RETURNING id",
                      **scene, revision);
  if (!snapshot) return snapshot.error();
  return RestoredScene{**scene, **snapshot};
}

/// There is no snapshot of revision 0: the log begins there.
Status publish_restored(Database& database, const RestoredScene& restored, bool replace) {
  if (!replace) {
    std::optional<std::string> other;
    Status read = database.each(
        "SELECT name FROM scene WHERE removed = 0 AND name = (SELECT name FROM scene WHERE id = ?)",
        [&](const Row& row) {
          other = row.text(0);
          return Status();
        },
        restored.scene);
    if (!read) return read;
    if (other) return scene_exists(*other);
  }
  Status done = database.execute(
      "UPDATE scene SET removed = 1, garbage = 1 WHERE removed = 0 AND name = "
      "(SELECT name FROM scene WHERE id = ?)",
      restored.scene);
  if (done)
    done =
        database.execute("UPDATE scene SET removed = 0, garbage = 1 WHERE id = ?", restored.scene);
  if (!done) return done;
  return database.execute(
      "UPDATE snapshot SET state = CASE revision WHEN 0 THEN 2 ELSE 1 END WHERE id = ?",
      restored.snapshot);
}

}  // namespace sightline::server::store

// The rows of a scene that is restored.
#include "server/store/restored_rows.h"

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "server/store/blob_rows.h"
#include "server/store/scene_rows.h"

namespace sightline::server::store {
namespace {

/// The scenes of this name. A damaged index may lead to others, whose names differ.
Result<std::vector<SceneId>> find_others(Database& database, const std::string& name) {
  std::vector<SceneId> others;
  const Status read = database.each(
      "SELECT id FROM scene WHERE name = ? AND removed = 0",
      [&](const Row& row) {
        others.push_back(row.number(0));
        return Status();
      },
      name);
  if (!read) return read.error();
  return others;
}

Status remove_other(Database& database, SceneId scene, const std::string& name) {
  const auto row = lock_scene(database, scene);
  if (row && row->info.name != name)
    return database.corrupt(fmt::format("the index of names leads from {} to another scene", name));
  return mark_removed(database, scene);
}

}  // namespace

Result<SnapshotRow> begin_restored(Database& database, const SceneInfo& info,
                                   std::uint64_t revision,
                                   std::span<const blobs::BlobDigest> blobs) {
  SceneRow row;
  row.info = info;
  row.revision = row.base = revision;
  row.removed = true;
  const auto scene = insert_row(database, row);
  if (!scene) return scene.error();
  SnapshotRow base{.scene = row.key, .revision = revision, .named = sum_of_blobs(blobs)};
  const auto inserted = insert_row(database, base);
  if (!inserted) return inserted.error();
  return base;
}

/// There is no snapshot of revision 0: the log begins there.
Status publish_restored(Database& database, SnapshotRow base, std::uint64_t chunks, bool replace) {
  auto row = lock_scene(database, base.scene.id);
  if (!row) return row.error();
  const auto others = find_others(database, row->info.name);
  if (!others) return others.error();
  if (!replace && !others->empty()) return scene_exists(row->info.name);
  for (const SceneId other : *others) {
    Status removed = remove_other(database, other, row->info.name);
    // Another process may have removed it meanwhile.
    if (!removed && removed.error().code != Code::kNotFound) return removed;
  }
  row->removed = false;
  row->garbage = true;
  if (Status done = write_scene(database, *row); !done) return done;
  return publish_base(database, base, chunks);
}

}  // namespace sightline::server::store

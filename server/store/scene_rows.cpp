// The table of scenes.
#include "server/store/scene_rows.h"

#include <fmt/format.h>

#include <algorithm>

namespace sightline::server::store {
namespace {

SceneRecord read_record(const Row& row) {
  SceneRecord record;
  record.id = row.number(0);
  record.info.name = row.text(1);
  record.info.incarnation = row.unsigned_number(2);
  record.info.up_axis = static_cast<UpAxis>(row.number(3));
  record.info.meters_per_unit = row.real(4);
  record.revision = row.unsigned_number(5);
  record.base = row.unsigned_number(6);
  record.log_bytes = row.unsigned_number(7);
  return record;
}

}  // namespace

Error scene_exists(const std::string& name) {
  return {Code::kAlreadyExists, fmt::format("the scene {} exists", name), "SCENE_EXISTS"};
}

Error no_scene(SceneId scene) {
  return {Code::kNotFound, fmt::format("the scene with the number {} is not stored", scene),
          "SCENE_NOT_FOUND"};
}

Result<SceneId> insert_scene(Database& database, const SceneInfo& info) {
  const auto id = database.number(
      "INSERT INTO scene(name, incarnation, up_axis, meters_per_unit) VALUES(?, ?, ?, ?) "
      "ON CONFLICT DO NOTHING RETURNING id",
      info.name, info.incarnation, static_cast<std::int64_t>(info.up_axis), info.meters_per_unit);
  if (!id) return id.error();
  if (*id) return **id;
  return scene_exists(info.name);
}

Result<SceneRecord> find_scene(Database& database, SceneId scene) {
  std::vector<SceneRecord> found;
  Status read = database.each(
      "SELECT id, name, incarnation, up_axis, meters_per_unit, revision, base, "
      "logged - base_logged FROM scene WHERE id = ? AND removed = 0",
      [&](const Row& row) {
        found.push_back(read_record(row));
        return Status();
      },
      scene);
  if (!read) return read.error();
  if (found.empty()) return no_scene(scene);
  read = database.each(
      "SELECT revision FROM snapshot WHERE scene = ? AND state = 1 ORDER BY revision",
      [&](const Row& row) {
        found.front().snapshots.push_back(row.unsigned_number(0));
        return Status();
      },
      scene);
  if (!read) return read.error();
  return std::move(found.front());
}

Result<std::optional<SceneRecord>> find_scene_named(Database& database, const std::string& name) {
  const auto id = database.number("SELECT id FROM scene WHERE name = ? AND removed = 0", name);
  if (!id) return id.error();
  if (!*id) return std::optional<SceneRecord>();
  auto record = find_scene(database, **id);
  if (!record) return record.error();
  return std::optional(std::move(*record));
}

Result<std::vector<SceneHead>> all_heads(Database& database) {
  std::vector<SceneHead> heads;
  const Status read = database.each("SELECT id, revision FROM scene WHERE removed = 0 ORDER BY id",
                                    [&](const Row& row) {
                                      heads.push_back({row.number(0), row.unsigned_number(1)});
                                      return Status();
                                    });
  if (!read) return read.error();
  return heads;
}

Result<std::vector<SceneRecord>> all_scenes(Database& database) {
  std::vector<SceneRecord> scenes;
  Status read = database.each(
      "SELECT id, name, incarnation, up_axis, meters_per_unit, revision, base, "
      "logged - base_logged FROM scene WHERE removed = 0 ORDER BY id",
      [&](const Row& row) {
        scenes.push_back(read_record(row));
        return Status();
      });
  if (!read) return read.error();
  read =
      database.each("SELECT scene, revision FROM snapshot WHERE state = 1 ORDER BY scene, revision",
                    [&](const Row& row) {
                      const auto scene = std::lower_bound(
                          scenes.begin(), scenes.end(), row.number(0),
                          [](const SceneRecord& one, SceneId id) { return one.id < id; });
                      if (scene != scenes.end() && scene->id == row.number(0))
                        scene->snapshots.push_back(row.unsigned_number(1));
                      return Status();
                    });
  if (!read) return read.error();
  std::sort(scenes.begin(), scenes.end(),
            [](const SceneRecord& a, const SceneRecord& b) { return a.info.name < b.info.name; });
  return scenes;
}

Status mark_removed(Database& database, SceneId scene) {
  if (Status done = database.execute(
          "UPDATE scene SET removed = 1, garbage = 1 WHERE id = ? AND removed = 0", scene);
      !done)
    return done;
  if (database.changes() == 0) return no_scene(scene);
  return {};
}

}  // namespace sightline::server::store

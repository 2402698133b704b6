// The table of scenes.
#include "server/store/scene_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <random>
#include <tuple>

#include "server/store/snapshot_rows.h"

namespace sightline::server::store {
namespace {

/// A scene as the table has it, and its seal there.
struct StoredRow {
  SceneRow row;
  std::int64_t seal = 0;

  bool sound() const { return seal == row.seal(); }
};

constexpr const char* kSelect =
    "SELECT id, name, incarnation, up_axis, meters_per_unit, revision, logged, base, base_logged, "
    "answers, answer_nodes, uid, answer_sum, producer_sum, edits, lost, removed, garbage, seal "
    "FROM scene WHERE id BETWEEN ? AND ? ORDER BY id";

StoredRow read_stored(const Row& row) {
  StoredRow stored;
  SceneRow& scene = stored.row;
  int column = 0;
  scene.key.id = row.number(column++);
  scene.info.name = row.text(column++);
  scene.info.incarnation = row.unsigned_number(column++);
  scene.info.up_axis = static_cast<UpAxis>(row.number(column++));
  scene.info.meters_per_unit = row.real(column++);
  for (std::uint64_t* number : {&scene.revision, &scene.logged, &scene.base, &scene.base_logged,
                                &scene.answers, &scene.answer_nodes, &scene.key.uid,
                                &scene.answer_sum, &scene.producer_sum, &scene.edits, &scene.lost})
    *number = row.unsigned_number(column++);
  scene.removed = row.number(column++) != 0;
  scene.garbage = row.number(column++) != 0;
  stored.seal = row.number(column++);
  return stored;
}

Error damaged_row(const Database& database, SceneId scene) {
  return database.corrupt(
      fmt::format("the row of the scene with the number {} does not match its checksum", scene));
}

Error cut_log(const Database& database, const SceneRow& row) {
  return database.corrupt(fmt::format(
      "the log of {} ends at revision {}, but revision {} was acknowledged: an older copy was put "
      "back, or its end is lost (sightlined doctor --accept-loss goes on without)",
      row.info.name, row.revision, row.lost));
}

Result<std::optional<StoredRow>> find_row(Database& database, const char* query, SceneId scene) {
  std::optional<StoredRow> found;
  const Status read = database.each(
      query,
      [&](const Row& row) {
        found = read_stored(row);
        return Status();
      },
      scene, scene);
  if (!read) return read.error();
  if (found && found->row.key.id != scene) return damaged_row(database, scene);
  return found;
}

/// The query for a row. Where others write, too, it holds the row until the transaction ends.
const char* locking(const Database& database) {
  static const std::string kLocked = std::string(kSelect) + " FOR UPDATE";
  return database.shared() ? kLocked.c_str() : kSelect;
}

SceneRecord record_of(const SceneRow& row) {
  return {row.key.id, row.info, row.revision, row.base, {}, row.logged - row.base_logged};
}

/// A random number, never 0.
std::uint64_t fresh_number() {
  std::random_device device;
  constexpr unsigned kHalf = 32;
  return std::uint64_t{device()} << kHalf | device() | 1;
}

}  // namespace

Error scene_exists(const std::string& name) {
  return {Code::kAlreadyExists, fmt::format("the scene {} exists", name), "SCENE_EXISTS"};
}

Error no_scene(SceneId scene) {
  return {Code::kNotFound, fmt::format("the scene with the number {} is not stored", scene),
          "SCENE_NOT_FOUND"};
}

std::int64_t SceneRow::seal() const {
  Seal seal(RowKind::kScene, key);
  seal.add(info.name).add(info.incarnation).add(static_cast<std::uint64_t>(info.up_axis));
  seal.add(info.meters_per_unit);
  for (const std::uint64_t number : {revision, logged, base, base_logged, answers, answer_nodes,
                                     answer_sum, producer_sum, edits, lost})
    seal.add(number);
  return seal.add(std::uint64_t{removed}).add(std::uint64_t{garbage}).value();
}

Result<SceneId> insert_scene(Database& database, const SceneInfo& info) {
  SceneRow row;
  row.info = info;
  const auto id = insert_row(database, row);
  if (!id) return id.error();
  if (*id) return **id;
  return scene_exists(info.name);
}

/// The row is written in two steps, as its number is part of the seal.
Result<std::optional<SceneId>> insert_row(Database& database, SceneRow& row) {
  row.key.uid = fresh_number();
  auto id = database.number(
      "INSERT INTO scene(name, incarnation, up_axis, meters_per_unit, removed, uid) "
      "VALUES(?, ?, ?, ?, ?, ?) ON CONFLICT DO NOTHING RETURNING id",
      row.info.name, row.info.incarnation, static_cast<std::int64_t>(row.info.up_axis),
      row.info.meters_per_unit, std::int64_t{row.removed}, row.key.uid);
  if (!id || !*id) return id;
  row.key.id = **id;
  if (const Status written = write_scene(database, row); !written) return written.error();
  return id;
}

Result<SceneRow> read_scene(Database& database, SceneId scene) {
  auto found = find_row(database, kSelect, scene);
  if (!found) return found.error();
  if (!*found) return no_scene(scene);
  if (!(*found)->sound()) return damaged_row(database, scene);
  SceneRow& row = (*found)->row;
  if (row.removed) return no_scene(scene);
  if (row.lost > 0) return cut_log(database, row);
  return std::move(row);
}

Result<SceneRow> lock_scene(Database& database, SceneId scene) {
  auto found = find_row(database, locking(database), scene);
  if (!found) return found.error();
  if (!*found) return no_scene(scene);
  if (!(*found)->sound()) return damaged_row(database, scene);
  return std::move((*found)->row);
}

Status write_scene(Database& database, SceneRow& row) {
  ++row.edits;
  return database.execute(
      "UPDATE scene SET incarnation = ?, revision = ?, logged = ?, base = ?, base_logged = ?, "
      "answers = ?, answer_nodes = ?, answer_sum = ?, producer_sum = ?, edits = ?, lost = ?, "
      "removed = ?, garbage = ?, seal = ? WHERE id = ?",
      row.info.incarnation, row.revision, row.logged, row.base, row.base_logged, row.answers,
      row.answer_nodes, row.answer_sum, row.producer_sum, row.edits, row.lost,
      std::int64_t{row.removed}, std::int64_t{row.garbage}, row.seal(), row.key.id);
}

Result<std::vector<ScannedScene>> scan_scenes(Database& database) {
  std::vector<ScannedScene> scenes;
  const Status read = database.each(
      kSelect,
      [&](const Row& row) {
        StoredRow stored = read_stored(row);
        const bool sound = stored.sound();
        scenes.push_back({std::move(stored.row), sound});
        return Status();
      },
      std::numeric_limits<SceneId>::min(), std::numeric_limits<SceneId>::max());
  if (!read) return read.error();
  return scenes;
}

Result<SceneRecord> find_scene(Database& database, SceneId scene) {
  const auto row = read_scene(database, scene);
  if (!row) return row.error();
  SceneRecord record = record_of(*row);
  const auto snapshots = complete_snapshots(database, row->key);
  if (!snapshots) return snapshots.error();
  for (const SnapshotRow& snapshot : *snapshots) record.snapshots.push_back(snapshot.revision);
  return record;
}

Result<std::optional<SceneRecord>> find_scene_named(Database& database, const std::string& name) {
  const auto id = database.number("SELECT id FROM scene WHERE name = ? AND removed = 0", name);
  if (!id) return id.error();
  if (!*id) return std::optional<SceneRecord>();
  auto record = find_scene(database, **id);
  if (!record) return record.error();
  if (record->info.name != name) return damaged_row(database, **id);
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
  const auto scanned = scan_scenes(database);
  if (!scanned) return scanned.error();
  std::vector<SceneRecord> scenes;
  for (const ScannedScene& scene : *scanned) {
    if (scene.row.removed && scene.sound) continue;
    const bool whole = scene.sound && scene.row.lost == 0;
    SceneRecord record;
    if (whole) record = record_of(scene.row);
    record.id = scene.row.key.id;
    record.info.name = scene.row.info.name;
    record.damaged = !whole;
    scenes.push_back(std::move(record));
  }
  std::ranges::sort(scenes, [](const SceneRecord& a, const SceneRecord& b) {
    return std::tie(a.damaged, a.info.name) < std::tie(b.damaged, b.info.name);
  });
  return scenes;
}

/// A damaged row is sealed as it is: of a scene that is removed only the number counts.
Status mark_removed(Database& database, SceneId scene) {
  auto found = find_row(database, locking(database), scene);
  if (!found) return found.error();
  if (!*found) return no_scene(scene);
  SceneRow& row = (*found)->row;
  if (row.removed && (*found)->sound()) return no_scene(scene);
  row.removed = true;
  row.garbage = true;
  return write_scene(database, row);
}

Status renew_history(Database& database, SceneRow row) {
  row.info.incarnation = fresh_number();
  row.lost = 0;
  return write_scene(database, row);
}

}  // namespace sightline::server::store

// The table of scenes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/store/database.h"
#include "server/store/seal.h"
#include "server/store/store.h"

namespace sightline::server::store {

/// All columns of a scene's row.
struct SceneRow {
  SceneKey key;
  SceneInfo info;
  std::uint64_t revision = 0;      ///< The newest revision.
  std::uint64_t logged = 0;        ///< Bytes of updates since the scene was made.
  std::uint64_t base = 0;          ///< See SceneRecord::base.
  std::uint64_t base_logged = 0;   ///< `logged` at the base.
  std::uint64_t answers = 0;       ///< Number of answers that are kept.
  std::uint64_t answer_nodes = 0;  ///< Node ids in them.
  std::uint64_t answer_sum = 0;    ///< Sum of the seals of answers.
  std::uint64_t producer_sum = 0;  ///< Sum of the seals of producers and of their puts.
  std::uint64_t edits = 0;         ///< How often the row was written.
  std::uint64_t lost = 0;          ///< The newest revision of a log that was cut; 0: it was not.
  bool removed = false;
  bool garbage = false;  ///< Rows of the scene are to be purged.

  std::int64_t seal() const;
};

/// What a full scan finds. A damaged row has the columns as they are.
struct ScannedScene {
  SceneRow row;
  bool sound = false;  ///< The row matches its seal.
};

/// Errors of all: as Database.

/// Errors: also kAlreadyExists.
Result<SceneId> insert_scene(Database& database, const SceneInfo& info);
/// Adds a row, and gives it its key. Nothing: there is one of this name, which is not removed.
Result<std::optional<SceneId>> insert_row(Database& database, SceneRow& row);
/// The row, if it is that of the scene. Errors: also kNotFound, kDataLoss (it does not match its
/// seal, or the log of the scene was cut).
Result<SceneRow> read_scene(Database& database, SceneId scene);
/// The row, which no other transaction changes until this one ends; also of a scene that is removed
/// or whose log was cut. Errors: also kNotFound, kDataLoss (it does not match its seal).
Result<SceneRow> lock_scene(Database& database, SceneId scene);
/// Writes all columns. The row counts the edit.
Status write_scene(Database& database, SceneRow& row);
/// All rows, by number, without an index.
Result<std::vector<ScannedScene>> scan_scenes(Database& database);

/// Errors: also kNotFound, kDataLoss.
Result<SceneRecord> find_scene(Database& database, SceneId scene);
/// The scene of this name; nothing if there is none. Errors: also kDataLoss.
Result<std::optional<SceneRecord>> find_scene_named(Database& database, const std::string& name);
/// The scenes by name, damaged ones last: of these only name and number are set.
Result<std::vector<SceneRecord>> all_scenes(Database& database);
/// The newest revisions of all scenes, by id.
Result<std::vector<SceneHead>> all_heads(Database& database);
/// Makes the scene's rows garbage, also if its own row is damaged. Errors: also kNotFound.
Status mark_removed(Database& database, SceneId scene);
/// Gives the scene a new incarnation, so that older tokens are refused. Its log then counts as
/// whole.
Status renew_history(Database& database, SceneRow row);
/// The error for a name that another scene has.
Error scene_exists(const std::string& name);
/// The error for a scene that is not there.
Error no_scene(SceneId scene);

}  // namespace sightline::server::store

// Takes a scene back to an earlier revision.
#include "server/store/roll_back.h"

#include <fmt/format.h>

#include "server/store/data_directory.h"
#include "server/store/scene_rows.h"

namespace sightline::server::store {
namespace {

/// Errors: kNotFound.
Result<SceneRecord> find_by_name(SqliteDatabase& database, const std::string& name) {
  const auto id = database.number("SELECT id FROM scene WHERE name = ? AND removed = 0", name);
  if (!id) return id.error();
  if (!*id)
    return Error{Code::kNotFound, fmt::format("there is no scene {}", name), "SCENE_NOT_FOUND"};
  return find_scene(database, **id);
}

/// What each statement does is told at roll_back(). ?1: the scene, ?2: the revision.
constexpr const char* kDropLater[] = {
    "DELETE FROM batch WHERE scene = ?1 AND revision > ?2",
    "UPDATE snapshot SET state = 2 WHERE scene = ?1 AND revision > ?2",
    "DELETE FROM answer WHERE scene = ?1 AND revision > ?2",
    "DELETE FROM put WHERE scene = ?1",
    "DELETE FROM producer WHERE scene = ?1",
    ("UPDATE scene SET revision = ?2, garbage = 1, logged = "
     "coalesce((SELECT logged FROM batch WHERE scene = ?1 AND revision = ?2), base_logged),"
     "answers = (SELECT count(*) FROM answer WHERE scene = ?1), answer_nodes = "
     "(SELECT coalesce(sum(node_count), 0) FROM answer WHERE scene = ?1) WHERE id = ?1"),
};

Status drop_later(SqliteDatabase& database, const SceneRecord& scene, std::uint64_t revision,
                  std::uint64_t incarnation) {
  for (const char* query : kDropLater) {
    if (Status done = database.execute(query, scene.id, revision); !done) return done;
  }
  return database.execute("UPDATE scene SET incarnation = ? WHERE id = ?", incarnation, scene.id);
}

}  // namespace

Status roll_back(FileSystem& files, const std::filesystem::path& directory,
                 const std::string& scene, std::uint64_t revision, std::uint64_t incarnation) {
  const auto opened = DataDirectory::open(files, directory);
  if (!opened) return opened.error();
  auto database = opened->open_database();
  if (!database) return database.error();
  const auto record = find_by_name(*database, scene);
  if (!record) return record.error();
  if (revision < record->base || revision > record->revision) {
    return Error{Code::kOutOfRange,
                 fmt::format("{} can be taken back to revisions {} to {}, not to {}", scene,
                             record->base, record->revision, revision),
                 "REVISION_NOT_KEPT"};
  }
  if (Status begun = database->run("BEGIN IMMEDIATE"); !begun) return begun;
  Status done = drop_later(*database, *record, revision, incarnation);
  if (done) done = database->commit();
  if (!done && database->in_transaction()) (void)database->run("ROLLBACK");
  return done;
}

}  // namespace sightline::server::store

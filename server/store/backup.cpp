// Copies of a data directory.
#include "server/store/backup.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <memory>
#include <set>

#include "server/store/blob_rows.h"
#include "server/store/scene_rows.h"

namespace sightline::server::store {
namespace {

struct FinishBackup {
  void operator()(sqlite3_backup* backup) const { sqlite3_backup_finish(backup); }
};

/// Copies all pages as they are at one instant.
Status copy_database(const DataDirectory& from, const std::filesystem::path& to) {
  FileSystem& files = from.files();
  auto source = Database::open(database_file(from.path()), files.database_vfs());
  if (!source) return source.error();
  auto target = Database::open(to, files.database_vfs());
  if (!target) return target.error();
  const std::unique_ptr<sqlite3_backup, FinishBackup> backup(
      sqlite3_backup_init(target->handle(), "main", source->handle(), "main"));
  if (!backup) return target->error();
  if (sqlite3_backup_step(backup.get(), -1) != SQLITE_DONE) {
    const Error of_source = source->error();
    return of_source.code == Code::kInternal ? target->error() : of_source;
  }
  return {};
}

Result<std::vector<BlobRow>> blobs_of(FileSystem& files, const std::filesystem::path& database) {
  auto opened = Database::open(database, files.database_vfs());
  if (!opened) return opened.error();
  return all_blobs(*opened);
}

Status link_blobs(FileSystem& files, const BlobFiles& from, const BlobFiles& to,
                  const std::vector<BlobRow>& rows) {
  std::set<std::filesystem::path> directories;
  for (const BlobRow& row : rows) {
    const auto target = to.path_of(row.digest);
    Status linked = files.link_or_copy(from.path_of(row.digest), target);
    if (!linked) return linked;
    directories.insert(target.parent_path());
  }
  for (const auto& directory : directories) {
    if (Status synced = files.sync_directory(directory); !synced) return synced;
  }
  return {};
}

Status expect_empty(FileSystem& files, const std::filesystem::path& directory) {
  const auto found = files.list(directory);
  if (!found) return found.error();
  if (found->empty()) return {};
  return Error{Code::kFailedPrecondition,
               fmt::format("{} is not empty; name a new directory", directory.string()),
               "BACKUP_NOT_EMPTY"};
}

}  // namespace

/// The database gets its name last: a directory without it is no backup.
Status copy_store(const DataDirectory& from, const BlobFiles& blobs,
                  const std::filesystem::path& to) {
  FileSystem& files = from.files();
  if (Status made = files.make_directory(to); !made) return made;
  if (Status empty = expect_empty(files, to); !empty) return empty;
  const auto unnamed = to / "incomplete.db";
  if (Status copied = copy_database(from, unnamed); !copied) return copied;
  const auto rows = blobs_of(files, unnamed);
  if (!rows) return rows.error();
  BlobFiles target(files, to);
  if (Status made = target.prepare(); !made) return made;
  if (Status linked = link_blobs(files, blobs, target, *rows); !linked) return linked;
  if (Status renamed = files.rename(unnamed, database_file(to)); !renamed) return renamed;
  return files.sync_directory(to);
}

Status restore_store(FileSystem& files, const std::filesystem::path& from,
                     const std::filesystem::path& to) {
  if (!files.exists(database_file(from))) {
    return Error{Code::kNotFound,
                 fmt::format("{} holds no backup: there is no {}", from.string(),
                             database_file(from).filename().string()),
                 "NO_BACKUP"};
  }
  const auto opened = DataDirectory::open(files, from);
  if (!opened) return opened.error();
  if (const auto current = opened->open_database(); !current) return current.error();
  return copy_store(*opened, BlobFiles(files, from), to);
}

namespace {

/// Errors: kNotFound.
Result<SceneRecord> find_by_name(Database& database, const std::string& name) {
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
    "DELETE FROM put WHERE scene = ?1 AND ?2 >= 0",
    "DELETE FROM producer WHERE scene = ?1 AND ?2 >= 0",
    "UPDATE scene SET revision = ?2, garbage = 1, "
    "logged = coalesce((SELECT logged FROM batch WHERE scene = ?1 AND revision = ?2), base_logged),"
    "answers = (SELECT count(*) FROM answer WHERE scene = ?1), answer_nodes = "
    "(SELECT coalesce(sum(node_count), 0) FROM answer WHERE scene = ?1) WHERE id = ?1",
};

Status drop_later(Database& database, const SceneRecord& scene, std::uint64_t revision,
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
  if (done) done = database->run("COMMIT");
  if (!done && database->in_transaction()) (void)database->run("ROLLBACK");
  return done;
}

}  // namespace sightline::server::store

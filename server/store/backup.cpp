// Copies of a data directory.
#include "server/store/backup.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <memory>
#include <set>

#include "server/store/blob_rows.h"

namespace sightline::server::store {
namespace {

struct FinishBackup {
  void operator()(sqlite3_backup* backup) const { sqlite3_backup_finish(backup); }
};

/// Copies all pages as they are at one instant.
Status copy_database(const DataDirectory& from, const std::filesystem::path& to) {
  const FileSystem& files = from.files();
  auto source = SqliteDatabase::open(database_file(from.path()), files.database_vfs());
  if (!source) return source.error();
  auto target = SqliteDatabase::open(to, files.database_vfs());
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
  auto opened = SqliteDatabase::open(database, files.database_vfs());
  if (!opened) return opened.error();
  return all_blobs(*opened);
}

Status link_blobs(FileSystem& files, const BlobFiles& from, const BlobFiles& to,
                  const std::vector<BlobRow>& rows) {
  std::set<std::filesystem::path> directories;
  for (const BlobRow& row : rows) {
    const auto target = to.path_of(row.digest);
    Status linked = files.link_or_copy(from.path_of(row.digest), target);
    if (!linked && linked.error().reason == "FILE_MISSING") continue;  // lost before
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

}  // namespace sightline::server::store

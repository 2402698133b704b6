// Looks for damage in a data directory that no process uses.
#include "server/store/doctor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>
#include <utility>

#include "server/store/blob_files.h"
#include "server/store/blob_rows.h"
#include "server/store/data_directory.h"
#include "server/store/log_rows.h"
#include "server/store/row_checks.h"

namespace sightline::server::store {
namespace {

class Doctor {
 public:
  Doctor(const DataDirectory& directory, SqliteDatabase& database, bool repair)
      : files_(directory.files()),
        path_(directory.path()),
        database_(database),
        blobs_(files_, path_),
        repair_(repair) {}

  Status examine() {
    if (Status checked = check_rows(database_, found_.findings); !checked) return checked;
    auto rows = all_blobs(database_);
    if (!rows) return rows.error();
    for (const BlobRow& row : *rows) {
      if (Status checked = check_blob(row); !checked) return checked;
    }
    return check_orphans(*rows);
  }

  Examination found() && { return std::move(found_); }

 private:
  Status check_blob(const BlobRow& row) {
    const auto mapped = blobs_.map(row.digest);
    std::string wrong;
    if (!mapped) {
      wrong = mapped.error().message;
    } else if (!matches((*mapped)->bytes(), row.digest)) {
      const auto path = blobs_.path_of(row.digest);
      wrong = corrupt_blob(path, row.digest, "has other bytes").message;
    } else {
      return {};
    }
    const auto scenes = scenes_of_blob(database_, row.id);
    if (!scenes) return scenes.error();
    found_.findings.push_back(scenes->empty()
                                  ? wrong + "; no scene uses it"
                                  : fmt::format("{}; used by {}", wrong, fmt::join(*scenes, ", ")));
    return repair_ ? move_aside(row.digest) : Status();
  }

  /// The row stays, as scenes name it: a new upload gives it a file again.
  Status move_aside(const blobs::BlobDigest& digest) {
    const auto from = blobs_.path_of(digest);
    if (!files_.exists(from)) return {};
    const auto lost = path_ / "lost";
    const auto to = lost / from.filename();
    Status moved = files_.make_directory(lost);
    if (moved) moved = files_.rename(from, to);
    if (moved) moved = files_.sync_directory(lost);
    if (moved) moved = files_.sync_directory(from.parent_path());
    if (moved) found_.repairs.push_back(fmt::format("moved {} to {}", from.string(), to.string()));
    return moved;
  }

  Status check_orphans(const std::vector<BlobRow>& rows) {
    std::set<std::filesystem::path> named;
    for (const BlobRow& row : rows) named.insert(blobs_.path_of(row.digest));
    auto orphans = blobs_.list();
    if (!orphans) return orphans.error();
    std::erase_if(*orphans, [&](const FileEntry& file) { return named.contains(file.path); });
    auto unfinished = blobs_.list_fresh();
    if (!unfinished) return unfinished.error();
    orphans->insert(orphans->end(), unfinished->begin(), unfinished->end());
    for (const FileEntry& file : *orphans) {
      if (Status done = report_orphan(file); !done) return done;
    }
    return {};
  }

  Status report_orphan(const FileEntry& file) {
    found_.findings.push_back(
        fmt::format("{} ({} bytes) is not named by the database; nothing is "
                    "lost",
                    file.path.string(), file.size));
    if (!repair_) return {};
    if (Status removed = files_.remove(file.path); !removed) return removed;
    found_.repairs.push_back("removed " + file.path.string());
    return {};
  }

  FileSystem& files_;
  const std::filesystem::path& path_;
  SqliteDatabase& database_;
  BlobFiles blobs_;
  const bool repair_;
  Examination found_;
};

}  // namespace

Result<Examination> examine(FileSystem& files, const std::filesystem::path& directory,
                            bool repair) {
  const auto file = database_file(directory);
  if (!files.exists(file)) {
    return Error{
        Code::kNotFound,
        fmt::format("there is no {}; name the directory that --data-dir names", file.string()),
        "NO_STORE"};
  }
  const auto opened = DataDirectory::open(files, directory);
  if (!opened) return opened.error();
  auto database = opened->open_database();
  if (!database) return database.error();
  Doctor doctor(*opened, *database, repair);
  if (const Status done = doctor.examine(); !done) return done.error();
  return std::move(doctor).found();
}

}  // namespace sightline::server::store

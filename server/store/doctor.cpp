// Looks for damage in a data directory that no process uses.
#include "server/store/doctor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>
#include <utility>

#include "server/store/blob_files.h"
#include "server/store/blob_rows.h"
#include "server/store/data_directory.h"
#include "server/store/head_marks.h"
#include "server/store/history.h"
#include "server/store/row_checks.h"

namespace sightline::server::store {
namespace {

class Doctor {
 public:
  Doctor(const DataDirectory& directory, SqliteDatabase& database, const Treatment& treatment)
      : files_(directory.files()),
        path_(directory.path()),
        database_(database),
        blobs_(files_, path_),
        treatment_(treatment) {}

  Status examine() {
    if (Status checked = check_rows(database_, found_.findings); !checked) return checked;
    if (Status checked = check_marks(); !checked) return checked;
    auto rows = all_blobs(database_);
    if (!rows) return was_found(rows.error()) ? Status() : Status(rows.error());
    for (const BlobRow& row : *rows) {
      if (Status checked = check_blob(row); !checked) return checked;
    }
    return check_orphans(*rows);
  }

  Examination found() && { return std::move(found_); }

 private:
  Status check_marks() {
    auto marks = HeadMarks::open(files_, marks_file(path_));
    if (!marks) return marks.error();
    if (marks->damaged() > 0) {
      found_.findings.push_back(
          fmt::format("{}: {} marks are damaged", marks_file(path_).string(), marks->damaged()));
    }
    const auto compared = compare_history(database_, *marks);
    if (!compared) return was_found(compared.error()) ? Status() : Status(compared.error());
    for (const HistoryFinding& finding : *compared) found_.findings.push_back(finding.text);
    if (!treatment_.accept_loss) return {};
    auto lines = accept_history(database_, *marks);
    if (!lines) return lines.error();
    found_.repairs.insert(found_.repairs.end(), lines->begin(), lines->end());
    return {};
  }

  /// Whether the error is damage that has been found before.
  static bool was_found(const Error& error) { return error.code == Code::kDataLoss; }

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
    return treatment_.repair ? move_aside(row.digest) : Status();
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
    if (!treatment_.repair) return {};
    if (Status removed = files_.remove(file.path); !removed) return removed;
    found_.repairs.push_back("removed " + file.path.string());
    return {};
  }

  FileSystem& files_;
  const std::filesystem::path& path_;
  SqliteDatabase& database_;
  BlobFiles blobs_;
  const Treatment treatment_;
  Examination found_;
};

}  // namespace

Result<Examination> examine(FileSystem& files, const std::filesystem::path& directory,
                            const Treatment& treatment) {
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
  Doctor doctor(*opened, *database, treatment);
  if (const Status done = doctor.examine(); !done) return done.error();
  return std::move(doctor).found();
}

}  // namespace sightline::server::store

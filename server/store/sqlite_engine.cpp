// SQLite as a writer uses it: its write-ahead log, its pages, its disk.
#include "server/store/sqlite_engine.h"

#include <sqlite3.h>

#include <iterator>
#include <string_view>
#include <utility>

#include "server/store/errors.h"
#include "server/store/purge.h"
#include "server/store/scene_rows.h"

namespace sightline::server::store {
namespace {

/// Pages in the write-ahead log from which on they are moved to the database.
constexpr int kCheckpointPages = 4096;
/// Pages that may stay free for new rows: a share of all, and at least a number.
constexpr std::int64_t kFreeShare = 4;
constexpr std::int64_t kFreePages = 4096;

int pages_in_log(void* count, sqlite3* /*handle*/, const char* /*name*/, int pages) {
  *static_cast<int*>(count) = pages;
  return SQLITE_OK;
}

void note_row(void* scenes, int /*change*/, const char* /*database*/, const char* table,
              sqlite3_int64 row) {
  if (std::string_view(table) == "scene") static_cast<std::set<SceneId>*>(scenes)->insert(row);
}

}  // namespace

SqliteEngine::SqliteEngine(SqliteDatabase database, DiskBudget& budget, HeadMarks& marks)
    : database_(std::move(database)), budget_(budget), marks_(marks) {
  sqlite3_wal_hook(database_.handle(), pages_in_log, &log_pages_);
  sqlite3_update_hook(database_.handle(), note_row, &touched_);
  measure();
}

SqliteEngine::~SqliteEngine() { (void)marks_.sync(); }

Status SqliteEngine::commit() {
  Status committed = database_.commit();
  if (committed) mark_touched();
  return committed;
}

/// Writes the marks before those who wait for the commit hear of it. A mark that cannot be written
/// is written later: until then less is noticed, and nothing is lost.
void SqliteEngine::mark_touched() {
  for (auto it = touched_.begin(); it != touched_.end();) {
    const auto row = lock_scene(database_, *it);
    const bool gone = row ? row->removed : row.error().code == Code::kNotFound;
    Status done;
    if (gone) {
      done = marks_.erase(*it);
    } else if (row) {
      done = marks_.set({row->key, row->edits, row->revision});
    } else if (row.error().code != Code::kDataLoss) {
      done = row.error();
    }
    it = done ? touched_.erase(it) : std::next(it);
  }
}

/// There is one writer: scenes need no locks.
Status SqliteEngine::begin(std::span<const SceneId> /*scenes*/) {
  if (Status healed = heal(); !healed) return healed;
  return database_.run("BEGIN IMMEDIATE");
}

void SqliteEngine::failed(const Error& error) {
  if (is_of_engine(error)) unhealed_ = true;
}

Result<bool> SqliteEngine::purge(bool all) {
  auto more = purge_some(database_);
  if (!more) return more;
  if (const Status returned = return_pages(all); !returned) return returned.error();
  return more;
}

/// Gives a bounded number of free pages back to the file system, if they are many, or `all`.
Status SqliteEngine::return_pages(bool all) {
  const auto free = database_.number("PRAGMA freelist_count");
  if (!free) return free.error();
  const auto pages = database_.number("PRAGMA page_count");
  if (!pages) return pages.error();
  const bool many = **free > kFreePages && **free > **pages / kFreeShare;
  if (**free == 0 || (!many && !all)) return {};
  return database_.execute("PRAGMA incremental_vacuum(1024)");
}

/// After a failed transaction, the write-ahead log may end in pages of which it is unknown whether
/// they are on disk. Moving all that was committed to the database and cutting the log removes
/// them.
Status SqliteEngine::heal() {
  if (!unhealed_) return {};
  if (sqlite3_wal_checkpoint_v2(database_.handle(), nullptr, SQLITE_CHECKPOINT_TRUNCATE, nullptr,
                                nullptr) != SQLITE_OK)
    return database_.error();
  unhealed_ = false;
  return {};
}

void SqliteEngine::transaction_ended(bool tight) {
  checkpoint(tight);
  measure();
}

/// A checkpoint that fails is tried again later: the log still has everything. It does not wait for
/// readers: the log begins anew when there is none.
void SqliteEngine::checkpoint(bool tight) {
  if (unhealed_ || (log_pages_ < kCheckpointPages && !tight)) return;
  int pages = 0;
  int moved = 0;
  const int code = sqlite3_wal_checkpoint_v2(database_.handle(), nullptr, SQLITE_CHECKPOINT_PASSIVE,
                                             &pages, &moved);
  if (code != SQLITE_OK || pages != moved) return;
  log_pages_ = 0;
  (void)marks_.sync();  // marks become as durable as what left the log
}

void SqliteEngine::measure() {
  const auto size = database_.number("PRAGMA page_size");
  const auto pages = database_.number("PRAGMA page_count");
  const auto free = database_.number("PRAGMA freelist_count");
  if (!size || !pages || !free) return;
  budget_.set_database(static_cast<std::uint64_t>((**pages - **free + log_pages_) * **size));
}

}  // namespace sightline::server::store

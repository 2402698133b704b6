// The tables of a store, and their versions.
#include "server/store/schema.h"

#include <fmt/format.h>

#include <array>
#include <string>
#include <vector>

#include "server/store/checksum.h"
#include "server/store/reseal.h"

namespace sightline::server::store {
namespace {

/// "SLst", in the header of the file.
constexpr int kApplicationId = 0x534C7374;

// `seal` covers a row (seal.h); `named`: sum of the blobs that rows name; `uid`, `edits`, `lost`
// and the sums: scene_rows.h. Rows of a scene that was removed, or that its base has passed, are
// garbage: purge.cpp deletes them step by step. `logged` counts the bytes of updates since the
// scene was made.
constexpr const char* kTables = R"(
  CREATE TABLE scene(
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    name TEXT NOT NULL,
    incarnation INTEGER NOT NULL,
    up_axis INTEGER NOT NULL CHECK(up_axis BETWEEN 0 AND 2),
    meters_per_unit REAL NOT NULL,
    revision INTEGER NOT NULL DEFAULT 0,
    logged INTEGER NOT NULL DEFAULT 0,
    base INTEGER NOT NULL DEFAULT 0,
    base_logged INTEGER NOT NULL DEFAULT 0,
    answers INTEGER NOT NULL DEFAULT 0,
    answer_nodes INTEGER NOT NULL DEFAULT 0,
    removed INTEGER NOT NULL DEFAULT 0,
    garbage INTEGER NOT NULL DEFAULT 0,
    uid INTEGER NOT NULL DEFAULT 0,
    answer_sum INTEGER NOT NULL DEFAULT 0,
    producer_sum INTEGER NOT NULL DEFAULT 0,
    edits INTEGER NOT NULL DEFAULT 0,
    lost INTEGER NOT NULL DEFAULT 0,
    seal INTEGER NOT NULL DEFAULT 0) STRICT;
  CREATE UNIQUE INDEX scene_name ON scene(name) WHERE removed = 0;
  CREATE INDEX scene_garbage ON scene(id) WHERE garbage = 1;

  CREATE TABLE blob(
    id INTEGER PRIMARY KEY,
    sum BLOB NOT NULL UNIQUE CHECK(length(sum) = 32),
    size INTEGER NOT NULL,
    stored INTEGER NOT NULL) STRICT;

  CREATE TABLE batch(
    id INTEGER PRIMARY KEY,
    scene INTEGER NOT NULL REFERENCES scene(id),
    revision INTEGER NOT NULL,
    time INTEGER NOT NULL,
    logged INTEGER NOT NULL,
    checksum INTEGER NOT NULL,
    updates BLOB NOT NULL,
    named INTEGER NOT NULL DEFAULT 0,
    seal INTEGER NOT NULL DEFAULT 0,
    UNIQUE(scene, revision)) STRICT;
  CREATE TABLE batch_blob(
    batch INTEGER NOT NULL REFERENCES batch(id) ON DELETE CASCADE,
    blob INTEGER NOT NULL REFERENCES blob(id),
    PRIMARY KEY(batch, blob)) STRICT, WITHOUT ROWID;
  CREATE INDEX batch_blob_blob ON batch_blob(blob);

  CREATE TABLE answer(
    id INTEGER PRIMARY KEY,
    scene INTEGER NOT NULL REFERENCES scene(id),
    request_id TEXT NOT NULL,
    content INTEGER NOT NULL,
    revision INTEGER NOT NULL,
    node_count INTEGER NOT NULL,
    nodes BLOB NOT NULL,
    seal INTEGER NOT NULL DEFAULT 0,
    UNIQUE(scene, request_id)) STRICT;
  CREATE INDEX answer_order ON answer(scene);

  CREATE TABLE producer(
    scene INTEGER NOT NULL REFERENCES scene(id),
    name TEXT NOT NULL,
    last_committed INTEGER NOT NULL,
    seal INTEGER NOT NULL DEFAULT 0,
    PRIMARY KEY(scene, name)) STRICT, WITHOUT ROWID;
  CREATE TABLE put(
    scene INTEGER NOT NULL,
    producer TEXT NOT NULL,
    sequence INTEGER NOT NULL,
    node_count INTEGER NOT NULL,
    nodes BLOB NOT NULL,
    seal INTEGER NOT NULL DEFAULT 0,
    PRIMARY KEY(scene, producer, sequence),
    FOREIGN KEY(scene, producer) REFERENCES producer(scene, name)) STRICT, WITHOUT ROWID;

  CREATE TABLE snapshot(
    id INTEGER PRIMARY KEY,
    scene INTEGER NOT NULL REFERENCES scene(id),
    revision INTEGER NOT NULL,
    state INTEGER NOT NULL,
    chunks INTEGER NOT NULL DEFAULT 0,
    named INTEGER NOT NULL DEFAULT 0,
    seal INTEGER NOT NULL DEFAULT 0) STRICT;
  CREATE UNIQUE INDEX snapshot_revision ON snapshot(scene, revision) WHERE state < 2;
  CREATE INDEX snapshot_scene ON snapshot(scene);
  CREATE TABLE snapshot_chunk(
    id INTEGER PRIMARY KEY,
    snapshot INTEGER NOT NULL REFERENCES snapshot(id),
    number INTEGER NOT NULL,
    checksum INTEGER NOT NULL,
    data BLOB NOT NULL,
    seal INTEGER NOT NULL DEFAULT 0,
    UNIQUE(snapshot, number)) STRICT;
  CREATE TABLE snapshot_blob(
    snapshot INTEGER NOT NULL REFERENCES snapshot(id),
    blob INTEGER NOT NULL REFERENCES blob(id),
    PRIMARY KEY(snapshot, blob)) STRICT, WITHOUT ROWID;
  CREATE INDEX snapshot_blob_blob ON snapshot_blob(blob);
)";

/// Figures of the store. `tables`: checksum of their definitions; `marked`: 1 once there is a file
/// of marks beside the database.
constexpr const char* kFigures =
    "CREATE TABLE figure(name TEXT NOT NULL PRIMARY KEY, value INTEGER NOT NULL) STRICT;"
    "INSERT INTO figure VALUES('tables', 0), ('marked', 0)";

/// Version 1 had no checksums of updates.
Status add_checksums(SqliteDatabase& database) {
  if (Status added =
          database.run("ALTER TABLE batch ADD COLUMN checksum INTEGER NOT NULL DEFAULT 0");
      !added)
    return added;
  std::int64_t last = 0;
  for (bool more = true; more;) {
    more = false;
    std::int64_t checksum = 0;
    Status done = database.each(
        "SELECT id, updates FROM batch WHERE id > ? ORDER BY id LIMIT 1",
        [&](const Row& row) {
          more = true;
          last = row.number(0);
          checksum = checksum_of(row.bytes(1));
          return Status();
        },
        last);
    if (done && more)
      done = database.execute("UPDATE batch SET checksum = ? WHERE id = ?", checksum, last);
    if (!done) return done;
  }
  return {};
}

/// Version 2 had checksums of bytes only.
Status add_seals(SqliteDatabase& database) {
  Status done = database.run(
      "ALTER TABLE scene ADD COLUMN uid INTEGER NOT NULL DEFAULT 0;"
      "ALTER TABLE scene ADD COLUMN answer_sum INTEGER NOT NULL DEFAULT 0;"
      "ALTER TABLE scene ADD COLUMN producer_sum INTEGER NOT NULL DEFAULT 0;"
      "ALTER TABLE scene ADD COLUMN edits INTEGER NOT NULL DEFAULT 0;"
      "ALTER TABLE scene ADD COLUMN lost INTEGER NOT NULL DEFAULT 0;"
      "ALTER TABLE scene ADD COLUMN seal INTEGER NOT NULL DEFAULT 0;"
      "ALTER TABLE batch ADD COLUMN named INTEGER NOT NULL DEFAULT 0;"
      "ALTER TABLE batch ADD COLUMN seal INTEGER NOT NULL DEFAULT 0;"
      "ALTER TABLE answer ADD COLUMN seal INTEGER NOT NULL DEFAULT 0;"
      "ALTER TABLE producer ADD COLUMN seal INTEGER NOT NULL DEFAULT 0;"
      "ALTER TABLE put ADD COLUMN seal INTEGER NOT NULL DEFAULT 0;"
      "ALTER TABLE snapshot ADD COLUMN chunks INTEGER NOT NULL DEFAULT 0;"
      "ALTER TABLE snapshot ADD COLUMN named INTEGER NOT NULL DEFAULT 0;"
      "ALTER TABLE snapshot ADD COLUMN seal INTEGER NOT NULL DEFAULT 0;"
      "ALTER TABLE snapshot_chunk ADD COLUMN seal INTEGER NOT NULL DEFAULT 0");
  if (done) done = database.run(kFigures);
  return done ? seal_all(database) : done;
}

/// Entry v - 1 brings version v to the next.
constexpr std::array<Status (*)(SqliteDatabase&), kSchemaVersion - 1> kMigrations{add_checksums,
                                                                                  add_seals};

/// The checksum of the definitions, not of where tables begin, which a VACUUM changes, nor of what
/// ANALYZE adds.
Result<std::int64_t> checksum_of_tables(SqliteDatabase& database) {
  std::string all;
  const Status read = database.each(
      "SELECT type, name, tbl_name, coalesce(sql, '') FROM sqlite_schema "
      "WHERE name NOT LIKE 'sqlite_stat%' ORDER BY type, name",
      [&](const Row& row) {
        for (int column = 0; column < 4; ++column) all += row.text(column) + '\n';
        return Status();
      });
  if (!read) return read.error();
  return checksum_of(as_bytes(all));
}

Status check_tables(SqliteDatabase& database) {
  const auto made = database.number("SELECT value FROM figure WHERE name = 'tables'");
  if (!made) return made.error();
  const auto found = checksum_of_tables(database);
  if (!found) return found.error();
  if (*made == *found) return {};
  return database.corrupt("the definitions of its tables are not those that it was made with");
}

Status set_version(SqliteDatabase& database) {
  const auto tables = checksum_of_tables(database);
  if (!tables) return tables.error();
  if (Status set = database.execute("UPDATE figure SET value = ? WHERE name = 'tables'", *tables);
      !set)
    return set;
  return database.run(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}",
                                  kApplicationId, kSchemaVersion)
                          .c_str());
}

Error newer(const SqliteDatabase& database, std::int64_t version) {
  return {Code::kFailedPrecondition,
          fmt::format("{} was written by a newer version of this program (format {}, this one "
                      "knows up to {}); use that version, or restore a backup made by this one",
                      database.file().string(), version, kSchemaVersion),
          "STORE_NEWER"};
}

Error foreign(const SqliteDatabase& database) {
  return {Code::kFailedPrecondition,
          fmt::format("{} is a database of another program; name another directory",
                      database.file().string()),
          "NOT_A_STORE"};
}

/// Makes or migrates the tables, in a transaction.
Status bring_up(SqliteDatabase& database, std::int64_t version) {
  if (version == 0) {
    Status made = database.run(kTables);
    if (made) made = database.run(kFigures);
    if (!made) return made;
  } else {
    for (auto step = static_cast<std::size_t>(version - 1); step < kMigrations.size(); ++step) {
      if (Status migrated = kMigrations[step](database); !migrated) return migrated;
    }
  }
  return set_version(database);
}

}  // namespace

Status configure(SqliteDatabase& database) {
  // auto_vacuum is set before there are tables: free pages can then be given back to the file
  // system.
  return database.run(
      "PRAGMA auto_vacuum = INCREMENTAL;"
      "PRAGMA journal_mode = WAL;"
      "PRAGMA synchronous = FULL;"
      "PRAGMA foreign_keys = ON;"
      "PRAGMA wal_autocheckpoint = 0;"
      "PRAGMA journal_size_limit = 67108864;"
      "PRAGMA temp_store = MEMORY;"
      "PRAGMA cell_size_check = ON;"
      "PRAGMA trusted_schema = OFF");
}

Status prepare_tables(SqliteDatabase& database) {
  const auto version = database.number("PRAGMA user_version");
  if (!version) return version.error();
  const auto application = database.number("PRAGMA application_id");
  if (!application) return application.error();
  const auto tables = database.number("SELECT count(*) FROM sqlite_schema");
  if (!tables) return tables.error();
  const bool fresh = **version == 0 && **application == 0 && **tables == 0;
  if (!fresh && **application != kApplicationId) return foreign(database);
  if (**version > kSchemaVersion) return newer(database, **version);
  if (**version == kSchemaVersion) return check_tables(database);
  if (Status begun = database.run("BEGIN IMMEDIATE"); !begun) return begun;
  Status done = bring_up(database, **version);
  if (done) done = database.commit();
  if (!done && database.in_transaction()) (void)database.run("ROLLBACK");
  return done;
}

}  // namespace sightline::server::store

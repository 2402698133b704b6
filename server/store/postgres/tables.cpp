// The tables of a store in PostgreSQL, and their versions.
#include "server/store/postgres/tables.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <string>

#include "server/store/reseal.h"
#include "server/store/scene_rows.h"

namespace sightline::server::store::postgres {
namespace {

/// The number of the lock under which one process at a time makes tables.
constexpr std::int64_t kTablesLock = 0x534C7374;

// The tables of the embedded form (server/store/schema.cpp), and beside them: the bytes of blobs
// (`content`, named by at most one blob), the last transaction of each writer, and leases. Numbers
// are of 64 bits, since the program binds no others. Names compare by their bytes.
constexpr const char* kMakeTables = R"(
  CREATE TABLE sightline_store(version BIGINT NOT NULL, home TEXT NOT NULL DEFAULT '');

  CREATE TABLE scene(
    id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    name TEXT COLLATE "C" NOT NULL,
    incarnation BIGINT NOT NULL,
    up_axis BIGINT NOT NULL CHECK(up_axis BETWEEN 0 AND 2),
    meters_per_unit DOUBLE PRECISION NOT NULL,
    revision BIGINT NOT NULL DEFAULT 0,
    logged BIGINT NOT NULL DEFAULT 0,
    base BIGINT NOT NULL DEFAULT 0,
    base_logged BIGINT NOT NULL DEFAULT 0,
    answers BIGINT NOT NULL DEFAULT 0,
    answer_nodes BIGINT NOT NULL DEFAULT 0,
    removed BIGINT NOT NULL DEFAULT 0,
    garbage BIGINT NOT NULL DEFAULT 0,
    uid BIGINT NOT NULL DEFAULT 0,
    answer_sum BIGINT NOT NULL DEFAULT 0,
    producer_sum BIGINT NOT NULL DEFAULT 0,
    edits BIGINT NOT NULL DEFAULT 0,
    lost BIGINT NOT NULL DEFAULT 0,
    seal BIGINT NOT NULL DEFAULT 0) WITH (fillfactor = 50);
  CREATE UNIQUE INDEX scene_name ON scene(name) WHERE removed = 0;
  CREATE INDEX scene_garbage ON scene(id) WHERE garbage = 1;

  CREATE TABLE content(
    id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    begun BIGINT NOT NULL,
    named BIGINT NOT NULL DEFAULT 0);
  CREATE INDEX content_unnamed ON content(begun) WHERE named = 0;
  CREATE TABLE content_chunk(
    content BIGINT NOT NULL REFERENCES content(id),
    number BIGINT NOT NULL,
    data BYTEA NOT NULL,
    PRIMARY KEY(content, number));
  ALTER TABLE content_chunk ALTER COLUMN data SET STORAGE EXTERNAL;
  CREATE TABLE blob(
    id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    sum BYTEA NOT NULL UNIQUE CHECK(length(sum) = 32),
    size BIGINT NOT NULL,
    stored BIGINT NOT NULL,
    content BIGINT NOT NULL REFERENCES content(id));

  CREATE TABLE batch(
    id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    scene BIGINT NOT NULL REFERENCES scene(id),
    revision BIGINT NOT NULL,
    time BIGINT NOT NULL,
    logged BIGINT NOT NULL,
    checksum BIGINT NOT NULL,
    updates BYTEA NOT NULL,
    named BIGINT NOT NULL DEFAULT 0,
    seal BIGINT NOT NULL DEFAULT 0,
    UNIQUE(scene, revision));
  CREATE TABLE batch_blob(
    batch BIGINT NOT NULL REFERENCES batch(id) ON DELETE CASCADE,
    blob BIGINT NOT NULL REFERENCES blob(id),
    PRIMARY KEY(batch, blob));
  CREATE INDEX batch_blob_blob ON batch_blob(blob);

  CREATE TABLE answer(
    id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    scene BIGINT NOT NULL REFERENCES scene(id),
    request_id TEXT COLLATE "C" NOT NULL,
    content BIGINT NOT NULL,
    revision BIGINT NOT NULL,
    node_count BIGINT NOT NULL,
    nodes BYTEA NOT NULL,
    seal BIGINT NOT NULL DEFAULT 0,
    UNIQUE(scene, request_id));
  CREATE INDEX answer_order ON answer(scene, id);

  CREATE TABLE producer(
    scene BIGINT NOT NULL REFERENCES scene(id),
    name TEXT COLLATE "C" NOT NULL,
    last_committed BIGINT NOT NULL,
    seal BIGINT NOT NULL DEFAULT 0,
    PRIMARY KEY(scene, name)) WITH (fillfactor = 50);
  CREATE TABLE put(
    scene BIGINT NOT NULL,
    producer TEXT COLLATE "C" NOT NULL,
    sequence BIGINT NOT NULL,
    node_count BIGINT NOT NULL,
    nodes BYTEA NOT NULL,
    seal BIGINT NOT NULL DEFAULT 0,
    PRIMARY KEY(scene, producer, sequence),
    FOREIGN KEY(scene, producer) REFERENCES producer(scene, name));

  CREATE TABLE snapshot(
    id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    scene BIGINT NOT NULL REFERENCES scene(id),
    revision BIGINT NOT NULL,
    state BIGINT NOT NULL,
    begun BIGINT NOT NULL DEFAULT (extract(epoch FROM clock_timestamp()) * 1000),
    chunks BIGINT NOT NULL DEFAULT 0,
    named BIGINT NOT NULL DEFAULT 0,
    seal BIGINT NOT NULL DEFAULT 0);
  CREATE UNIQUE INDEX snapshot_revision ON snapshot(scene, revision) WHERE state < 2;
  CREATE INDEX snapshot_scene ON snapshot(scene);
  CREATE INDEX snapshot_unfinished ON snapshot(begun) WHERE state = 0;
  CREATE TABLE snapshot_chunk(
    id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    snapshot BIGINT NOT NULL REFERENCES snapshot(id),
    number BIGINT NOT NULL,
    checksum BIGINT NOT NULL,
    data BYTEA NOT NULL,
    seal BIGINT NOT NULL DEFAULT 0,
    UNIQUE(snapshot, number));
  CREATE TABLE snapshot_blob(
    snapshot BIGINT NOT NULL REFERENCES snapshot(id),
    blob BIGINT NOT NULL REFERENCES blob(id),
    PRIMARY KEY(snapshot, blob));
  CREATE INDEX snapshot_blob_blob ON snapshot_blob(blob);

  CREATE TABLE writer(
    name TEXT COLLATE "C" PRIMARY KEY,
    transaction BIGINT NOT NULL,
    touched BIGINT NOT NULL DEFAULT (extract(epoch FROM clock_timestamp()) * 1000)) WITH (fillfactor = 10);
  CREATE TABLE lease(
    name TEXT COLLATE "C" PRIMARY KEY,
    holder TEXT COLLATE "C" NOT NULL,
    expires BIGINT NOT NULL);
)";

/// Version 1 had checksums of bytes only.
constexpr const char* kAddSeals = R"(
  ALTER TABLE sightline_store ADD COLUMN home TEXT NOT NULL DEFAULT '';
  ALTER TABLE scene ADD COLUMN uid BIGINT NOT NULL DEFAULT 0,
    ADD COLUMN answer_sum BIGINT NOT NULL DEFAULT 0,
    ADD COLUMN producer_sum BIGINT NOT NULL DEFAULT 0,
    ADD COLUMN edits BIGINT NOT NULL DEFAULT 0,
    ADD COLUMN lost BIGINT NOT NULL DEFAULT 0,
    ADD COLUMN seal BIGINT NOT NULL DEFAULT 0;
  ALTER TABLE batch ADD COLUMN named BIGINT NOT NULL DEFAULT 0,
    ADD COLUMN seal BIGINT NOT NULL DEFAULT 0;
  ALTER TABLE answer ADD COLUMN seal BIGINT NOT NULL DEFAULT 0;
  ALTER TABLE producer ADD COLUMN seal BIGINT NOT NULL DEFAULT 0;
  ALTER TABLE put ADD COLUMN seal BIGINT NOT NULL DEFAULT 0;
  ALTER TABLE snapshot ADD COLUMN chunks BIGINT NOT NULL DEFAULT 0,
    ADD COLUMN named BIGINT NOT NULL DEFAULT 0,
    ADD COLUMN seal BIGINT NOT NULL DEFAULT 0;
  ALTER TABLE snapshot_chunk ADD COLUMN seal BIGINT NOT NULL DEFAULT 0;
)";

/// A server of an older version that still runs would change rows and leave their seals: its
/// statements fail as if the database were closed, so that its clients go to others.
constexpr const char* kFence = R"(
  CREATE FUNCTION sightline_fence() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
    RAISE EXCEPTION 'a newer version has changed the tables: replace this server'
      USING ERRCODE = '57P03';
  END $$;
  CREATE TRIGGER fence BEFORE UPDATE ON scene FOR EACH ROW
    WHEN (NEW.seal = OLD.seal) EXECUTE FUNCTION sightline_fence();
  CREATE TRIGGER fence BEFORE UPDATE ON producer FOR EACH ROW
    WHEN (NEW.seal = OLD.seal) EXECUTE FUNCTION sightline_fence();
  CREATE TRIGGER fence BEFORE UPDATE ON snapshot FOR EACH ROW
    WHEN (NEW.seal = OLD.seal) EXECUTE FUNCTION sightline_fence();
  CREATE TRIGGER fence_new BEFORE INSERT ON scene FOR EACH ROW
    WHEN (NEW.uid = 0) EXECUTE FUNCTION sightline_fence();
  CREATE TRIGGER fence_new BEFORE INSERT ON producer FOR EACH ROW
    WHEN (NEW.seal = 0) EXECUTE FUNCTION sightline_fence();
)";

/// Asks which tables of which database of which cluster these are. A dump that is restored is
/// elsewhere, while a standby that is promoted is not.
constexpr const char* kHome =
    "SELECT concat_ws('/', (SELECT system_identifier FROM pg_control_system()), "
    "(SELECT oid FROM pg_database WHERE datname = current_database()), "
    "CAST(CAST('sightline_store' AS regclass) AS oid)), home FROM sightline_store";

/// Renews all scenes: older tokens are not taken any more.
Status renew_all(Connection& connection) {
  const auto scenes = scan_scenes(connection);
  if (!scenes) return scenes.error();
  for (const auto& [row, sound] : *scenes) {
    if (!sound || row.removed) continue;
    if (Status renewed = renew_history(connection, row); !renewed) return renewed;
  }
  return {};
}

/// Checks that the tables are where they were made. `known`: they have a home; else it is here.
Status check_home(Connection& connection, bool known) {
  std::string here;
  std::string home;
  Status done = connection.each(kHome, [&](const Row& row) {
    here = row.text(0);
    home = row.text(1);
    return Status();
  });
  if (!done || here == home) return done;
  if (known) {
    spdlog::warn("event=history_renewed home={} was={}", here, home);
    done = renew_all(connection);
  }
  return done ? connection.execute("UPDATE sightline_store SET home = ?", here) : done;
}

Status make(Connection& connection, const Address& address) {
  const auto others = connection.number("SELECT count(to_regclass('scene'))");
  if (!others) return others.error();
  if (**others != 0) {
    return Error{Code::kFailedPrecondition,
                 address.text() + " has tables of another program; name another database",
                 "NOT_A_STORE"};
  }
  Status made = connection.run(kMakeTables);
  if (made) made = connection.run(kFence);
  if (made) made = connection.execute("INSERT INTO sightline_store VALUES(?)", kTablesVersion);
  return made ? check_home(connection, false) : made;
}

Status migrate(Connection& connection) {
  Status done = connection.run(kAddSeals);
  if (done) done = seal_all(connection);
  if (done) done = connection.run(kFence);
  if (done) done = connection.execute("UPDATE sightline_store SET version = ?", kTablesVersion);
  return done ? check_home(connection, false) : done;
}

Status bring_up(Connection& connection, const Address& address) {
  if (Status locked = connection.execute("SELECT pg_advisory_xact_lock(?)", kTablesLock); !locked)
    return locked;
  const auto mine = connection.number("SELECT count(to_regclass('sightline_store'))");
  if (!mine) return mine.error();
  if (**mine == 0) return make(connection, address);
  const auto version = connection.number("SELECT version FROM sightline_store");
  if (!version) return version.error();
  const std::int64_t found = version->value_or(kTablesVersion + 1);
  if (found == 1) return migrate(connection);
  if (found == kTablesVersion) return check_home(connection, true);
  return Error{
      Code::kFailedPrecondition,
      fmt::format("{} was written by a newer version of this program (format {}, this one "
                  "knows up to {}); use that version, or restore a backup made by this one",
                  address.text(), version->value_or(0), kTablesVersion),
      "STORE_NEWER"};
}

}  // namespace

Status prepare_tables(Connection& connection, const Address& address) {
  return connection.transact("BEGIN",
                             [&](Database& /*database*/) { return bring_up(connection, address); });
}

Result<std::int64_t> now(Database& database) {
  const auto time =
      database.number("SELECT CAST(extract(epoch FROM clock_timestamp()) * 1000 AS BIGINT)");
  if (!time) return time.error();
  return time->value_or(0);
}

}  // namespace sightline::server::store::postgres

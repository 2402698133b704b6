// Directories that older, newer and other programs have written.
#include "server/store/schema.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "server/store/data_directory.h"
#include "tests/server/store/directory.h"
#include "tests/server/store/store_steps.h"

namespace sightline::server::store {
namespace {

using tests::Directory;
using tests::log_of;
using tests::open_store;
using tests::reason_of;

/// The tables of version 1, as they were then, with a scene of two revisions.
constexpr const char* kVersion1 = R"(
  CREATE TABLE scene(id INTEGER PRIMARY KEY AUTOINCREMENT, name TEXT NOT NULL,
    incarnation INTEGER NOT NULL, up_axis INTEGER NOT NULL CHECK(up_axis BETWEEN 0 AND 2),
    meters_per_unit REAL NOT NULL, revision INTEGER NOT NULL DEFAULT 0,
    logged INTEGER NOT NULL DEFAULT 0, base INTEGER NOT NULL DEFAULT 0,
    base_logged INTEGER NOT NULL DEFAULT 0, answers INTEGER NOT NULL DEFAULT 0,
    answer_nodes INTEGER NOT NULL DEFAULT 0, removed INTEGER NOT NULL DEFAULT 0,
    garbage INTEGER NOT NULL DEFAULT 0) STRICT;
  CREATE UNIQUE INDEX scene_name ON scene(name) WHERE removed = 0;
  CREATE INDEX scene_garbage ON scene(id) WHERE garbage = 1;
  CREATE TABLE blob(id INTEGER PRIMARY KEY, sum BLOB NOT NULL UNIQUE CHECK(length(sum) = 32),
    size INTEGER NOT NULL, stored INTEGER NOT NULL) STRICT;
  CREATE TABLE batch(id INTEGER PRIMARY KEY, scene INTEGER NOT NULL REFERENCES scene(id),
    revision INTEGER NOT NULL, time INTEGER NOT NULL, logged INTEGER NOT NULL,
    updates BLOB NOT NULL, UNIQUE(scene, revision)) STRICT;
  CREATE TABLE batch_blob(batch INTEGER NOT NULL REFERENCES batch(id) ON DELETE CASCADE,
    blob INTEGER NOT NULL REFERENCES blob(id), PRIMARY KEY(batch, blob)) STRICT, WITHOUT ROWID;
  CREATE INDEX batch_blob_blob ON batch_blob(blob);
  CREATE TABLE answer(id INTEGER PRIMARY KEY, scene INTEGER NOT NULL REFERENCES scene(id),
    request_id TEXT NOT NULL, content INTEGER NOT NULL, revision INTEGER NOT NULL,
    node_count INTEGER NOT NULL, nodes BLOB NOT NULL, UNIQUE(scene, request_id)) STRICT;
  CREATE INDEX answer_order ON answer(scene);
  CREATE TABLE producer(scene INTEGER NOT NULL REFERENCES scene(id), name TEXT NOT NULL,
    last_committed INTEGER NOT NULL, PRIMARY KEY(scene, name)) STRICT, WITHOUT ROWID;
  CREATE TABLE put(scene INTEGER NOT NULL, producer TEXT NOT NULL, sequence INTEGER NOT NULL,
    node_count INTEGER NOT NULL, nodes BLOB NOT NULL, PRIMARY KEY(scene, producer, sequence),
    FOREIGN KEY(scene, producer) REFERENCES producer(scene, name)) STRICT, WITHOUT ROWID;
  CREATE TABLE snapshot(id INTEGER PRIMARY KEY, scene INTEGER NOT NULL REFERENCES scene(id),
    revision INTEGER NOT NULL, state INTEGER NOT NULL) STRICT;
  CREATE UNIQUE INDEX snapshot_revision ON snapshot(scene, revision) WHERE state < 2;
  CREATE INDEX snapshot_scene ON snapshot(scene);
  CREATE TABLE snapshot_chunk(id INTEGER PRIMARY KEY,
    snapshot INTEGER NOT NULL REFERENCES snapshot(id), number INTEGER NOT NULL,
    checksum INTEGER NOT NULL, data BLOB NOT NULL, UNIQUE(snapshot, number)) STRICT;
  CREATE TABLE snapshot_blob(snapshot INTEGER NOT NULL REFERENCES snapshot(id),
    blob INTEGER NOT NULL REFERENCES blob(id), PRIMARY KEY(snapshot, blob)) STRICT, WITHOUT ROWID;
  CREATE INDEX snapshot_blob_blob ON snapshot_blob(blob);
  INSERT INTO scene(name, incarnation, up_axis, meters_per_unit, revision, logged)
    VALUES('projects/p/scenes/old', 5, 1, 0.5, 2, 11);
  INSERT INTO batch(scene, revision, time, logged, updates)
    VALUES(1, 1, 1700000000000, 5, CAST('first' AS BLOB)),
          (1, 2, 1700000000001, 11, CAST('second' AS BLOB));
  PRAGMA application_id = 1397519220;
  PRAGMA user_version = 1;
)";

/// Runs statements on the database of a directory.
void run(const Directory& directory, const char* statements) {
  auto database = SqliteDatabase::open(database_file(directory.path()), nullptr);
  ASSERT_TRUE(database.ok());
  const Status done = database->run(statements);
  ASSERT_TRUE(done.ok()) << done.error().message;
}

TEST(Schema, BringsADirectoryOfAnOlderVersionUp) {
  const Directory directory;
  run(directory, kVersion1);
  auto store = open_store(directory.path());
  ASSERT_NE(store, nullptr);
  const auto scenes = store->scenes();
  ASSERT_EQ(scenes->size(), 1u);
  const SceneRecord& scene = scenes->front();
  EXPECT_EQ(scene.info.name, "projects/p/scenes/old");
  EXPECT_EQ(scene.info.incarnation, 5u);
  EXPECT_EQ(scene.revision, 2u);
  const auto log = store->read(scene.id, 0, 1000);
  ASSERT_TRUE(log.ok()) << log.error().message;
  EXPECT_EQ(log->back().updates, "second");
  EXPECT_EQ(log->back().time.time_since_epoch(), std::chrono::milliseconds(1700000000001));
  EXPECT_TRUE(tests::append(*store, scene.id, 2, "third").ok());
  store.reset();
  store = open_store(directory.path());
  EXPECT_EQ(log_of(*store, 1)->size(), 3u);
}

TEST(Schema, RefusesADirectoryOfANewerVersion) {
  const Directory directory;
  open_store(directory.path()).reset();
  run(directory, fmt::format("PRAGMA user_version = {}", kSchemaVersion + 1).c_str());
  const auto refused = SqliteStore::open(directory.path());
  ASSERT_EQ(reason_of(refused), "STORE_NEWER");
  EXPECT_NE(refused.error().message.find(database_file(directory.path()).string()),
            std::string::npos);
  EXPECT_NE(refused.error().message.find(std::to_string(kSchemaVersion)), std::string::npos);
}

TEST(Schema, RefusesADatabaseOfAnotherProgram) {
  const Directory directory;
  run(directory, "CREATE TABLE theirs(x)");
  EXPECT_EQ(reason_of(SqliteStore::open(directory.path())), "NOT_A_STORE");
}

}  // namespace
}  // namespace sightline::server::store

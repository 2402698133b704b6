// Columns are changed and rows deleted behind the store's back: each call answers as before or says
// that it cannot, and the doctor finds it. Tables of older versions are sealed as they are.
#include <gtest/gtest.h>

#include "server/store/data_directory.h"
#include "server/store/doctor.h"
#include "server/store/head_marks.h"
#include "server/store/postgres/connection.h"
#include "tests/server/store/postgres/postgres_test.h"
#include "tests/server/store/stored_state.h"

namespace sightline::server::store {
namespace {

using tests::Directory;
using tests::fill_store;
using tests::open_store;
using tests::state_of;
using State = std::map<std::string, Result<std::string>>;

/// SQL of all engines. Scenes 2 and 3 are there, and have the same.
constexpr const char* kTampered[] = {
    "UPDATE batch SET updates = (SELECT updates FROM batch WHERE scene = 3 AND revision = 9), "
    "checksum = (SELECT checksum FROM batch WHERE scene = 3 AND revision = 9) "
    "WHERE scene = 2 AND revision = 9",
    "UPDATE batch SET revision = 100 - revision WHERE scene = 2 AND revision IN (9, 10)",
    "DELETE FROM batch_blob WHERE batch IN (SELECT id FROM batch WHERE scene = 2 AND revision = 7)",
    "UPDATE answer SET content = content + 1 WHERE scene = 2 AND revision = 9",
    "UPDATE answer SET revision = 8 WHERE scene = 2 AND revision = 9",
    "DELETE FROM answer WHERE scene = 2 AND revision = 9",
    "DELETE FROM put WHERE scene = 2 AND sequence = 9",
    "UPDATE put SET nodes = (SELECT nodes FROM put WHERE scene = 3 AND sequence = 8) "
    "WHERE scene = 2 AND sequence = 9",
    "DELETE FROM snapshot_chunk WHERE number = 2",
    "UPDATE snapshot_chunk SET number = 5 - number WHERE number IN (1, 2)",
};

/// In PostgreSQL a trigger refuses these to servers that know nothing of seals.
constexpr const char* kOfOneWriter[] = {
    "UPDATE scene SET revision = revision - 1 WHERE id = 2",
    "UPDATE scene SET up_axis = 1, meters_per_unit = 7 WHERE id = 2",
    "UPDATE producer SET last_committed = 99 WHERE scene = 2",
    "UPDATE snapshot SET revision = 5 WHERE scene = 2 AND revision = 4",
    "UPDATE snapshot SET chunks = 2 WHERE scene = 2",
};

void expect_same_or_refused(const State& want, const State& got, const std::string& statement) {
  for (const auto& [what, answer] : got) {
    // A scene that is damaged is left out of the list, and its name leads to an error.
    if (what == "names" || !answer) continue;
    EXPECT_EQ(*answer, *want.at(what)) << statement << ": " << what;
  }
}

void run(const Directory& directory, const std::string& statements) {
  auto database = SqliteDatabase::open(database_file(directory.path()), nullptr);
  ASSERT_TRUE(database.ok());
  const Status done = database->run(statements.c_str());
  ASSERT_TRUE(done.ok()) << statements << ": " << done.error().message;
}

void expect_found(const std::string& statement) {
  const Directory directory;
  fill_store(*open_store(directory.path()));
  const State want = state_of(*open_store(directory.path()));
  run(directory, statement);
  const auto found = examine(local_files(), directory.path(), {});
  ASSERT_TRUE(found.ok()) << found.error().message;
  EXPECT_FALSE(found->findings.empty()) << statement;
  expect_same_or_refused(want, state_of(*open_store(directory.path())), statement);
}

TEST(TamperedRows, AreFoundAndNeverServed) {
  for (const char* statement : kTampered) expect_found(statement);
  for (const char* statement : kOfOneWriter) expect_found(statement);
}

TEST(TamperedRows, TablesThatAreDefinedOtherwiseAreRefused) {
  const Directory directory;
  open_store(directory.path()).reset();
  run(directory, "CREATE INDEX another ON batch(time)");
  EXPECT_EQ(tests::reason_of(SqliteStore::open(directory.path())), "STORE_CORRUPT");
}

TEST(TamperedRows, RowsOfTheVersionBeforeAreSealed) {
  const Directory directory;
  fill_store(*open_store(directory.path()));
  const State want = state_of(*open_store(directory.path()));
  run(directory,
      "ALTER TABLE scene DROP COLUMN uid; ALTER TABLE scene DROP COLUMN answer_sum;"
      "ALTER TABLE scene DROP COLUMN producer_sum; ALTER TABLE scene DROP COLUMN edits;"
      "ALTER TABLE scene DROP COLUMN lost; ALTER TABLE scene DROP COLUMN seal;"
      "ALTER TABLE batch DROP COLUMN named; ALTER TABLE batch DROP COLUMN seal;"
      "ALTER TABLE answer DROP COLUMN seal; ALTER TABLE producer DROP COLUMN seal;"
      "ALTER TABLE put DROP COLUMN seal; ALTER TABLE snapshot DROP COLUMN chunks;"
      "ALTER TABLE snapshot DROP COLUMN named; ALTER TABLE snapshot DROP COLUMN seal;"
      "ALTER TABLE snapshot_chunk DROP COLUMN seal; DROP TABLE figure; PRAGMA user_version = 2");
  std::filesystem::remove(marks_file(directory.path()));
  const auto store = open_store(directory.path());
  const State got = state_of(*store);
  for (const auto& [what, answer] : got) EXPECT_TRUE(answer.ok()) << what;
  expect_same_or_refused(want, got, "version 2");
  EXPECT_EQ(store->scene(2)->info.incarnation, 100u) << "tokens are as before";
}

class TamperedTables : public tests::PostgresTest {};

TEST_F(TamperedTables, AreNeverServed) {
  fill_store(*open());
  const State want = state_of(*open());
  for (const char* statement : kTampered) {
    const std::string copy = server().make_database();
    fill_store(*one_.open(server().uri(copy)));
    server().run(copy, statement);
    expect_same_or_refused(want, state_of(*two_.open(server().uri(copy))), statement);
  }
}

TEST_F(TamperedTables, ServersOfTheVersionBeforeCannotWrite) {
  fill_store(*open());
  auto address = postgres::Address::parse(uri());
  for (const char* statement : kOfOneWriter) {
    const auto connection = postgres::Connection::open(*address);
    ASSERT_TRUE(connection.ok());
    EXPECT_EQ(tests::reason_of((*connection)->run(statement)), "STORE_IO") << statement;
  }
}

TEST_F(TamperedTables, OfTheVersionBeforeAreSealed) {
  fill_store(*open());
  const State want = state_of(*open());
  run("DROP FUNCTION sightline_fence CASCADE");
  run("ALTER TABLE sightline_store DROP COLUMN home");
  run("ALTER TABLE scene DROP COLUMN uid, DROP COLUMN answer_sum, DROP COLUMN producer_sum, "
      "DROP COLUMN edits, DROP COLUMN lost, DROP COLUMN seal");
  run("ALTER TABLE batch DROP COLUMN named, DROP COLUMN seal");
  run("ALTER TABLE snapshot DROP COLUMN chunks, DROP COLUMN named, DROP COLUMN seal");
  for (const char* table : {"answer", "producer", "put", "snapshot_chunk"})
    run(std::string("ALTER TABLE ") + table + " DROP COLUMN seal");
  run("UPDATE sightline_store SET version = 1");
  const auto store = open();
  const State got = state_of(*store);
  for (const auto& [what, answer] : got) EXPECT_TRUE(answer.ok()) << what;
  expect_same_or_refused(want, got, "version 1");
  EXPECT_EQ(store->scene(2)->info.incarnation, 100u) << "tokens are as before";
}

TEST_F(TamperedTables, ThatAreElsewhereGiveNewTokens) {
  fill_store(*open());
  EXPECT_EQ(open()->scene(2)->info.incarnation, 100u);
  run("UPDATE sightline_store SET home = ''");
  const auto renewed = open()->scene(2)->info.incarnation;
  EXPECT_NE(renewed, 100u);
  EXPECT_EQ(open()->scene(2)->info.incarnation, renewed);
}

TEST_F(TamperedTables, ManyMeshesAreAskedForAtOnceAndWrittenOnce) {
  const auto store = open();
  std::vector<blobs::BlobDigest> digests;
  for (int i = 0; i < 4; ++i) digests.push_back(tests::digest_of_blob(tests::blob_bytes(i)));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(tests::store_blob(*store, tests::blob_bytes(i)).ok());
  run("UPDATE blob SET stored = stored - 600000");
  const char* const versions = "SELECT string_agg(xmin::text, ' ' ORDER BY id) FROM blob";
  const std::string old = run(versions);
  EXPECT_EQ(store->has_blobs(digests), (std::vector<bool>{true, true, true, false}));
  const std::string touched = run(versions);
  EXPECT_NE(touched, old);
  EXPECT_EQ(touched, touched.substr(0, touched.find(' ')) + " " +
                         touched.substr(0, touched.find(' ')) + " " +
                         touched.substr(0, touched.find(' ')))
      << "one transaction";
  EXPECT_EQ(store->has_blobs(digests), (std::vector<bool>{true, true, true, false}));
  EXPECT_EQ(run(versions), touched) << "nothing is written again";
}

}  // namespace
}  // namespace sightline::server::store

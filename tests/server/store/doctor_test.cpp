// Damage of every kind: what is served all the same, what the doctor says, and what it repairs.
#include "server/store/doctor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "server/store/blob_files.h"
#include "server/store/data_directory.h"
#include "tests/server/store/directory.h"
#include "tests/server/store/store_steps.h"

namespace sightline::server::store {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using tests::append;
using tests::blob_bytes;
using tests::digest_of_blob;
using tests::Directory;
using tests::make_scene;
using tests::open_store;
using tests::reason_of;
using tests::store_blob;

/// Two scenes, "a" with a blob and "b" with another.
class Doctor : public testing::Test {
 protected:
  Doctor() {
    const auto store = open_store(directory_.path());
    for (int i = 0; i < 2; ++i) {
      EXPECT_TRUE(store_blob(*store, blob_bytes(i)).ok());
      scenes_[i] = make_scene(*store, i == 0 ? "a" : "b");
      for (std::uint64_t r = 0; r < 4; ++r)
        EXPECT_TRUE(append(*store, scenes_[i], r, "updates", {digest_of_blob(blob_bytes(i))}).ok());
    }
    EXPECT_TRUE(tests::put_snapshot(*store, scenes_[0], 2, {"one", "two"}).ok());
  }

  std::filesystem::path blob_file(int number) const {
    return BlobFiles(local_files(), directory_.path()).path_of(digest_of_blob(blob_bytes(number)));
  }

  void run(const char* statements) const {
    auto database = SqliteDatabase::open(database_file(directory_.path()), nullptr);
    ASSERT_TRUE(database.ok());
    const Status done = database->run(statements);
    ASSERT_TRUE(done.ok()) << done.error().message;
  }

  std::vector<std::string> findings(bool repair = false) const {
    const auto found = examine(local_files(), directory_.path(), {.repair = repair});
    EXPECT_TRUE(found.ok()) << found.error().message;
    return found ? found->findings : std::vector<std::string>();
  }

  Directory directory_;
  SceneId scenes_[2] = {};
};

TEST_F(Doctor, FindsNothingInASoundDirectory) { EXPECT_THAT(findings(), IsEmpty()); }

TEST_F(Doctor, NeedsADatabase) {
  const Directory empty;
  EXPECT_EQ(reason_of(examine(local_files(), empty.path(), {})), "NO_STORE");
}

TEST_F(Doctor, RefusesADirectoryInUse) {
  const auto store = open_store(directory_.path());
  EXPECT_EQ(reason_of(examine(local_files(), directory_.path(), {.repair = true})),
            "DATA_DIR_IN_USE");
}

TEST_F(Doctor, MovesACorruptBlobAsideSoThatItCanBeStoredAgain) {
  std::fstream(blob_file(0), std::ios::in | std::ios::out).seekp(500) << '#';
  {
    const auto store = open_store(directory_.path());
    const auto corrupt = store->blob(digest_of_blob(blob_bytes(0)));
    ASSERT_EQ(reason_of(corrupt), "BLOB_CORRUPT");
    EXPECT_EQ(corrupt.error().code, Code::kDataLoss);
    EXPECT_THAT(corrupt.error().message, HasSubstr(blob_file(0).string()));
    EXPECT_EQ(*tests::load_blob(*store, digest_of_blob(blob_bytes(1))), blob_bytes(1));
    EXPECT_TRUE(append(*store, scenes_[0], 4, "updates").ok());
  }
  EXPECT_THAT(findings(), ElementsAre(HasSubstr("has other bytes")));
  const auto repaired = examine(local_files(), directory_.path(), {.repair = true});
  ASSERT_TRUE(repaired.ok());
  EXPECT_THAT(repaired->findings, ElementsAre(HasSubstr("used by a")));
  EXPECT_THAT(repaired->repairs, ElementsAre(HasSubstr("lost")));
  EXPECT_THAT(findings(), ElementsAre(HasSubstr("is missing")));
  {
    const auto store = open_store(directory_.path());
    EXPECT_EQ(reason_of(store->blob(digest_of_blob(blob_bytes(0)))), "BLOB_CORRUPT");
    EXPECT_FALSE(store->has_blob(digest_of_blob(blob_bytes(0))));
    EXPECT_TRUE(store_blob(*store, blob_bytes(0)).ok());
    EXPECT_EQ(*tests::load_blob(*store, digest_of_blob(blob_bytes(0))), blob_bytes(0));
  }
  EXPECT_THAT(findings(), IsEmpty());
}

TEST_F(Doctor, FindsABlobThatWasCutShort) {
  std::filesystem::resize_file(blob_file(1), 10);
  EXPECT_THAT(findings(), ElementsAre(HasSubstr("has 10 bytes, not 1000")));
}

TEST_F(Doctor, RemovesOrphans) {
  const auto orphan = blob_file(7);
  std::filesystem::create_directories(orphan.parent_path());
  std::ofstream(orphan) << "x";
  EXPECT_THAT(findings(), ElementsAre(HasSubstr("is not named by the database")));
  EXPECT_TRUE(std::filesystem::exists(orphan));
  findings(true);
  EXPECT_FALSE(std::filesystem::exists(orphan));
  EXPECT_THAT(findings(), IsEmpty());
}

TEST_F(Doctor, FindsADamagedRevisionWhileTheOthersAreServed) {
  run("UPDATE batch SET updates = x'00' WHERE scene = 1 AND revision = 3");
  {
    const auto store = open_store(directory_.path());
    EXPECT_EQ(store->read(scenes_[0], 0, 14)->size(), 2u);
    const auto damaged = store->read(scenes_[0], 2, 1000);
    ASSERT_EQ(reason_of(damaged), "STORE_CORRUPT");
    EXPECT_EQ(damaged.error().code, Code::kDataLoss);
    EXPECT_EQ(tests::log_of(*store, scenes_[1])->size(), 4u);
  }
  EXPECT_THAT(findings(), ElementsAre(HasSubstr("a: revision 3 does not match its checksum")));
}

TEST_F(Doctor, FindsGapsInRevisions) {
  run("DELETE FROM batch WHERE scene = 2 AND revision IN (2, 3);"
      "DELETE FROM batch_blob WHERE batch NOT IN (SELECT id FROM batch)");
  EXPECT_THAT(findings(), ElementsAre(HasSubstr("b: revisions 2 to 3 are missing")));
  const auto store = open_store(directory_.path());
  EXPECT_EQ(reason_of(store->read(scenes_[1], 1, 1000)), "STORE_CORRUPT");
}

TEST_F(Doctor, FindsADamagedSnapshot) {
  run("UPDATE snapshot_chunk SET data = x'01' WHERE number = 1");
  EXPECT_THAT(findings(), ElementsAre(HasSubstr("a: chunk 1 of the snapshot of revision 2")));
  const auto store = open_store(directory_.path());
  EXPECT_EQ(*store->read_snapshot(scenes_[0], 2, 0), "one");
  EXPECT_EQ(reason_of(store->read_snapshot(scenes_[0], 2, 1)), "STORE_CORRUPT");
}

TEST_F(Doctor, FindsRowsThatNameMissingOnes) {
  run("PRAGMA foreign_keys = OFF; DELETE FROM blob WHERE id = 1");
  EXPECT_THAT(findings(), testing::Contains(HasSubstr("names a row of blob that is missing")));
}

}  // namespace
}  // namespace sightline::server::store

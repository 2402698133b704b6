// A database that went back behind what it had acknowledged: who notices, who is refused, and how
// an operator goes on.
#include "server/store/history.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "server/store/data_directory.h"
#include "server/store/doctor.h"
#include "tests/server/store/directory.h"
#include "tests/server/store/store_steps.h"

namespace sightline::server::store {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using tests::append;
using tests::Directory;
using tests::log_of;
using tests::make_scene;
using tests::open_store;
using tests::reason_of;

namespace fs = std::filesystem;
constexpr auto kOver = fs::copy_options::overwrite_existing;

/// Scene "a" at revision 4, "b" at 1, and a copy of the database when "a" was at 2.
class History : public testing::Test {
 protected:
  History() {
    {
      const auto store = open_store(path());
      a_ = make_scene(*store, "a");
      b_ = make_scene(*store, "b");
      EXPECT_TRUE(append(*store, b_, 0, "of b").ok());
      write(*store, 0, 2);
    }
    fs::copy_file(database_file(path()), old(), kOver);
    fs::copy_file(marks_file(path()), old_.path() / "heads", kOver);
    write(*open_store(path()), 2, 4);
  }

  void write(Store& store, std::uint64_t from, std::uint64_t to) const {
    for (std::uint64_t i = from; i < to; ++i) EXPECT_TRUE(append(store, a_, i, "update").ok());
  }

  const fs::path& path() const { return directory_.path(); }
  fs::path old() const { return old_.path() / "old.db"; }
  void put_old_back() const { fs::copy_file(old(), database_file(path()), kOver); }

  std::vector<std::string> findings(const Treatment& treatment = {}) const {
    const auto found = examine(local_files(), path(), treatment);
    EXPECT_TRUE(found.ok()) << found.error().message;
    return found ? found->findings : std::vector<std::string>();
  }

  Directory directory_;
  Directory old_;
  SceneId a_ = 0;
  SceneId b_ = 0;
};

TEST_F(History, AnOlderCopyIsRefusedUntilItIsAccepted) {
  put_old_back();
  EXPECT_THAT(findings(), ElementsAre(HasSubstr("revision 2, and revision 4 was acknowledged")));
  for (int restart = 0; restart < 2; ++restart) {
    const auto store = open_store(path());
    EXPECT_EQ(reason_of(store->scene(a_)), "STORE_CORRUPT");
    EXPECT_EQ(reason_of(store->read(a_, 0, 1000)), "STORE_CORRUPT");
    EXPECT_EQ(reason_of(append(*store, a_, 2, "more")), "STORE_CORRUPT");
    EXPECT_EQ(log_of(*store, b_)->size(), 1u);
    EXPECT_EQ(store->scenes()->back().info.name, "a") << "it is listed";
    EXPECT_TRUE(store->scenes()->back().damaged);
  }
  EXPECT_THAT(findings({.accept_loss = true}), testing::SizeIs(1));
  EXPECT_THAT(findings(), IsEmpty());
  const auto store = open_store(path());
  EXPECT_EQ(store->scene(a_)->revision, 2u);
  EXPECT_NE(store->scene(a_)->info.incarnation, 7u) << "tokens of revisions 3 and 4 are refused";
  EXPECT_EQ(store->scene(b_)->info.incarnation, 7u);
  write(*store, 2, 3);
}

TEST_F(History, ASceneThatWasCutCanBeRemovedOrReplaced) {
  put_old_back();
  const auto store = open_store(path());
  const auto restored = store->restore_scene(
      {.name = "a"}, 0, {}, []() -> Result<std::string> { return std::string(); }, true);
  ASSERT_TRUE(restored.ok()) << restored.error().message;
  EXPECT_EQ(reason_of(store->scene(a_)), "SCENE_NOT_FOUND");
  EXPECT_TRUE(append(*store, *restored, 0, "anew").ok());
}

TEST_F(History, AStoreWithoutAnAcknowledgedSceneDoesNotOpen) {
  const SceneId late = make_scene(*open_store(path()), "late");
  put_old_back();
  const auto refused = SqliteStore::open(path(), tests::small_disk());
  ASSERT_EQ(reason_of(refused), "STORE_CORRUPT");
  EXPECT_THAT(refused.error().message, HasSubstr("number " + std::to_string(late)));
  fs::remove(database_file(path()));
  EXPECT_EQ(reason_of(SqliteStore::open(path(), tests::small_disk())), "STORE_CORRUPT");
  findings({.accept_loss = true});
  EXPECT_TRUE(open_store(path())->scenes()->empty());
}

TEST_F(History, MarksThatAreBehindSayNothing) {
  fs::copy_file(old_.path() / "heads", marks_file(path()), kOver);
  EXPECT_THAT(findings(), IsEmpty());
  EXPECT_EQ(open_store(path())->scene(a_)->info.incarnation, 7u);
  put_old_back();
  EXPECT_EQ(reason_of(open_store(path())->scene(a_)), "STORE_CORRUPT") << "they have caught up";
}

TEST_F(History, WithoutMarksAllScenesGetNewTokens) {
  fs::remove(marks_file(path()));
  EXPECT_THAT(findings(), testing::SizeIs(2));
  const auto renewed = open_store(path())->scene(a_)->info.incarnation;
  EXPECT_NE(renewed, 7u);
  EXPECT_THAT(findings(), IsEmpty());
  const auto store = open_store(path());
  EXPECT_EQ(store->scene(a_)->info.incarnation, renewed);
  EXPECT_EQ(log_of(*store, a_)->size(), 4u);
}

TEST_F(History, ADamagedMarkIsSaid) {
  std::fstream(marks_file(path()), std::ios::in | std::ios::out).seekp(16) << '#';
  EXPECT_THAT(findings(), ElementsAre(HasSubstr("1 marks are damaged"), HasSubstr("a: its mark")));
  const auto store = open_store(path());
  EXPECT_NE(store->scene(a_)->info.incarnation, 7u);
  EXPECT_EQ(store->scene(b_)->info.incarnation, 7u);
}

TEST_F(History, ALogThatLostItsEndIsRefused) {
  const Directory crashed;
  {
    // As after a crash: the newest updates are in the write-ahead log alone.
    const auto store = open_store(path());
    write(*store, 4, 8);
    for (const char* name : {"sightline.db", "sightline.db-wal", "heads"})
      fs::copy_file(path() / name, crashed.path() / name);
  }
  const auto log = crashed.path() / "sightline.db-wal";
  std::fstream(log, std::ios::in | std::ios::out)
          .seekp(static_cast<std::streamoff>(fs::file_size(log) / 2))
      << "####";
  const auto store = open_store(crashed.path());
  EXPECT_EQ(reason_of(store->scene(a_)), "STORE_CORRUPT");
  EXPECT_EQ(log_of(*store, b_)->size(), 1u);
}

}  // namespace
}  // namespace sightline::server::store

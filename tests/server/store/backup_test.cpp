// Copies of a store in use, back again, and back to an earlier revision.
#include "server/store/backup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "server/store/doctor.h"
#include "server/store/roll_back.h"
#include "tests/server/store/directory.h"
#include "tests/server/store/store_steps.h"

namespace sightline::server::store {
namespace {

using tests::append;
using tests::blob_bytes;
using tests::digest_of_blob;
using tests::Directory;
using tests::log_of;
using tests::make_scene;
using tests::open_store;
using tests::reason_of;

void expect_sound(const std::filesystem::path& directory) {
  const auto found = examine(local_files(), directory, false);
  ASSERT_TRUE(found.ok()) << found.error().message;
  EXPECT_THAT(found->findings, testing::IsEmpty());
}

TEST(Backup, IsTakenWhileBatchesAreCommitted) {
  const Directory directory;
  const auto store = open_store(directory.path() / "store");
  const std::string bytes = blob_bytes(1, 100'000);
  ASSERT_TRUE(tests::store_blob(*store, bytes).ok());
  const SceneId scene = make_scene(*store, "a");
  ASSERT_TRUE(append(*store, scene, 0, "u", {digest_of_blob(bytes)}).ok());
  std::atomic<bool> ending{false};
  std::atomic<std::uint64_t> committed{1};
  std::thread writer([&] {
    for (; !ending; ++committed) EXPECT_TRUE(append(*store, scene, committed, "u").ok());
  });
  while (committed < 5) std::this_thread::yield();
  const std::uint64_t before = committed;
  const Status copied = store->backup(directory.path() / "copy");
  const std::uint64_t after = committed;
  ending = true;
  writer.join();
  ASSERT_TRUE(copied.ok()) << copied.error().message;
  EXPECT_EQ(reason_of(store->backup(directory.path() / "copy")), "BACKUP_NOT_EMPTY");

  expect_sound(directory.path() / "copy");
  ASSERT_TRUE(
      restore_store(local_files(), directory.path() / "copy", directory.path() / "new").ok());
  const auto restored = open_store(directory.path() / "new");
  ASSERT_NE(restored, nullptr);
  const std::uint64_t revision = restored->scene(scene)->revision;
  EXPECT_GE(revision, before);
  EXPECT_LE(revision, after + 1);
  EXPECT_EQ(log_of(*restored, scene)->size(), revision);
  EXPECT_EQ(*tests::load_blob(*restored, digest_of_blob(bytes)), bytes);
  EXPECT_TRUE(append(*restored, scene, revision, "u").ok());
}

TEST(Backup, LeavesOutABlobWhoseFileIsMissing) {
  const Directory directory;
  const auto store = open_store(directory.path() / "store");
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(tests::store_blob(*store, blob_bytes(i)).ok());
  const BlobFiles files(local_files(), directory.path() / "store");
  std::filesystem::remove(files.path_of(digest_of_blob(blob_bytes(0))));
  ASSERT_TRUE(store->backup(directory.path() / "copy").ok());
  const auto copy = open_store(directory.path() / "copy");
  EXPECT_EQ(reason_of(copy->blob(digest_of_blob(blob_bytes(0)))), "BLOB_CORRUPT");
  EXPECT_EQ(*tests::load_blob(*copy, digest_of_blob(blob_bytes(1))), blob_bytes(1));
}

TEST(Backup, IsRefusedWhereThereIsNone) {
  const Directory directory;
  EXPECT_EQ(reason_of(restore_store(local_files(), directory.path(), directory.path() / "new")),
            "NO_BACKUP");
}

TEST(RollBack, TakesASceneBackToARevision) {
  const Directory directory;
  auto store = open_store(directory.path());
  const SceneId scene = make_scene(*store, "a");
  for (std::uint64_t i = 0; i < 6; ++i) {
    Batch batch{scene,
                i,
                std::to_string(i + 1),
                {},
                RequestAnswer{std::to_string(i), 1, i + 1, {1}},
                {{"p", i + 1, {1}}}};
    ASSERT_TRUE(append(*store, batch).ok());
  }
  ASSERT_TRUE(tests::put_snapshot(*store, scene, 2, {"s"}).ok());
  ASSERT_TRUE(tests::put_snapshot(*store, scene, 5, {"s"}).ok());
  ASSERT_TRUE(store->drop_before(scene, 2).ok());
  store.reset();
  const auto roll = [&](const std::string& name, std::uint64_t revision) {
    return reason_of(roll_back(local_files(), directory.path(), name, revision, 99));
  };
  EXPECT_EQ(roll("b", 3), "SCENE_NOT_FOUND");
  EXPECT_EQ(roll("a", 1), "REVISION_NOT_KEPT");
  EXPECT_EQ(roll("a", 7), "REVISION_NOT_KEPT");
  EXPECT_EQ(roll("a", 4), "");
  expect_sound(directory.path());

  store = open_store(directory.path());
  const auto record = store->scene(scene);
  EXPECT_EQ(record->revision, 4u);
  EXPECT_EQ(record->log_bytes, 2u);
  EXPECT_EQ(record->info.incarnation, 99u);
  EXPECT_EQ(record->snapshots, std::vector<std::uint64_t>{2});
  EXPECT_EQ(*log_of(*store, scene, 2), (std::vector<std::string>{"3", "4"}));
  EXPECT_EQ(store->answers(scene)->size(), 4u);
  EXPECT_TRUE(store->producers(scene)->empty());
  EXPECT_TRUE(append(*store, scene, 4, "5").ok());
  store.reset();
  EXPECT_EQ(roll("a", 2), "");
  expect_sound(directory.path());
}

}  // namespace
}  // namespace sightline::server::store

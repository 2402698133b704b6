// The embedded store keeps its disk from filling up.
#include <gtest/gtest.h>

#include <filesystem>
#include <thread>

#include "server/store/sqlite_store.h"
#include "tests/server/store/directory.h"
#include "tests/server/store/store_steps.h"
#include "tests/support/sleep_shortly.h"

namespace sightline::server::store {
namespace {

using tests::append;
using tests::blob_bytes;
using tests::Directory;
using tests::make_scene;
using tests::reason_of;
using tests::store_blob;

TEST(DiskBounds, KeepsALeastFreeDisk) {
  const Directory directory;
  StoreLimits limits;
  limits.min_free_disk = std::uint64_t{1} << 60;
  const auto store = std::move(*SqliteStore::open(directory.path(), limits));
  const auto refused = store->create_scene({.name = "a"});
  EXPECT_EQ(reason_of(refused), "DISK_FULL");
  EXPECT_NE(refused.error().message.find("min_free_disk is 1152921504606846976"),
            std::string::npos);
  EXPECT_EQ(reason_of(store->writable()), "DISK_FULL");
  EXPECT_EQ(reason_of(store_blob(*store, "abc")), "DISK_FULL");
}

TEST(DiskBounds, BoundsTheBytesOnDisk) {
  const Directory directory;
  StoreLimits limits = tests::small_disk();
  limits.disk_bytes = 1 << 20;
  const auto store = std::move(*SqliteStore::open(directory.path(), limits));
  const SceneId scene = make_scene(*store, "a");
  EXPECT_EQ(reason_of(store_blob(*store, blob_bytes(1, 2 << 20))), "TOO_MANY_BYTES");
  std::uint64_t revision = 0;
  Status last;
  while ((last = append(*store, scene, revision, std::string(100'000, 'x'))) && revision < 100)
    ++revision;
  EXPECT_EQ(reason_of(last), "TOO_MANY_BYTES");
  EXPECT_GT(revision, 3u);
  // What is freed can be used again.
  ASSERT_TRUE(store->remove_scene(scene).ok());
  for (int i = 0; i < 1000 && store->figures().bytes_on_disk > limits.disk_bytes / 2; ++i) {
    store->flush();
    tests::sleep_shortly();
  }
  const SceneId next = make_scene(*store, "b");
  Status again = append(*store, next, 0, std::string(100'000, 'x'));
  for (int i = 0; i < 1000 && !again; ++i)
    again = append(*store, next, 0, std::string(100'000, 'x'));
  EXPECT_TRUE(again.ok()) << again.error().message;
}

TEST(DiskBounds, KeepsNoFileOfARefusedBlob) {
  const Directory directory;
  const auto store = tests::open_store(directory.path());
  const std::string bytes = blob_bytes(1);
  {
    const auto writer = std::move(*store->write_blob(tests::digest_of_blob(bytes)));
    ASSERT_TRUE(writer->append(std::as_bytes(std::span(bytes)).first(3)).ok());
    EXPECT_EQ(reason_of(writer->finish()), "DIGEST_MISMATCH");
  }
  EXPECT_TRUE(std::filesystem::is_empty(directory.path() / "blobs" / "tmp"));
}

}  // namespace
}  // namespace sightline::server::store

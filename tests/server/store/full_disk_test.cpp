// A disk that is really full: a small file system in memory, where the process may mount one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>

#include <chrono>
#include <fstream>
#include <limits>
#include <thread>

#include "server/store/doctor.h"
#include "tests/server/store/directory.h"
#include "tests/server/store/store_steps.h"

namespace sightline::server::store {
namespace {

/// Mounted in this process alone.
class SmallDisk {
 public:
  /// `size`: as the option of tmpfs.
  explicit SmallDisk(const std::string& size) {
    mounted_ = unshare(CLONE_NEWNS) == 0 &&
               mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
               mount("none", path().c_str(), "tmpfs", 0, ("size=" + size).c_str()) == 0;
  }
  ~SmallDisk() {
    if (mounted_) umount2(path().c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  bool mounted() const { return mounted_; }
  const std::filesystem::path& path() const { return directory_.path(); }

  /// Takes this number of blocks of 4 KiB, or all that are left, until release().
  void fill(int blocks) const {
    std::ofstream file(path() / "ballast", std::ios::app);
    const std::string block(4096, 'x');
    for (int i = 0; i < blocks && file.write(block.data(), 4096).flush(); ++i) continue;
  }
  void release() const { std::filesystem::remove(path() / "ballast"); }

 private:
  tests::Directory directory_;
  bool mounted_ = false;
};

constexpr int kAllBlocks = std::numeric_limits<int>::max();
constexpr std::size_t kUpdateSize = 50'000;

/// Appends until it is refused. Returns the newest revision; `reason` gets that of the refusal.
std::uint64_t append_until_full(Store& store, SceneId scene, std::string& reason) {
  std::uint64_t revision = 0;
  for (;;) {
    const Status done = tests::append(store, scene, revision, std::string(kUpdateSize, 'u'));
    reason = tests::reason_of(done);
    if (!done) return revision;
    ++revision;
  }
}

TEST(FullDisk, KeepsWhatItAcknowledgedAndGoesOnWithSpace) {
  const SmallDisk disk("16m");
  if (!disk.mounted()) GTEST_SKIP() << "this process may not mount";
  disk.fill(2048);
  const auto path = disk.path() / "store";
  auto store = tests::open_store(path);
  const std::string bytes = tests::blob_bytes(1);
  ASSERT_TRUE(tests::store_blob(*store, bytes).ok());
  const SceneId scene = tests::make_scene(*store, "a");
  std::string reason;
  const std::uint64_t last = append_until_full(*store, scene, reason);
  EXPECT_EQ(reason, "DISK_FULL");
  EXPECT_GT(last, 50u);

  disk.fill(kAllBlocks);
  EXPECT_EQ(tests::reason_of(tests::append(*store, scene, last, "u")), "DISK_FULL");
  EXPECT_EQ(tests::reason_of(tests::store_blob(*store, tests::blob_bytes(2))), "DISK_FULL");
  EXPECT_EQ(tests::reason_of(store->writable()), "DISK_FULL");
  EXPECT_EQ(tests::log_of(*store, scene)->size(), last);
  EXPECT_EQ(*tests::load_blob(*store, tests::digest_of_blob(bytes)), bytes);
  store.reset();
  disk.fill(kAllBlocks);
  // Opening needs a few pages, which the system may still have; what is there is served then.
  auto opened = SqliteStore::open(path, tests::small_disk());
  if (opened) {
    EXPECT_EQ(tests::log_of(**opened, scene)->size(), last);
    opened->reset();
  } else {
    EXPECT_EQ(opened.error().reason, "DISK_FULL");
  }

  disk.release();
  store = tests::open_store(path);
  ASSERT_NE(store, nullptr);
  EXPECT_EQ(tests::log_of(*store, scene)->size(), last);
  EXPECT_TRUE(tests::store_blob(*store, tests::blob_bytes(2)).ok());
  EXPECT_TRUE(tests::append(*store, scene, last, "u").ok());
  store.reset();
  const auto found = examine(local_files(), path, {});
  ASSERT_TRUE(found.ok()) << found.error().message;
  EXPECT_THAT(found->findings, testing::IsEmpty());
}

TEST(FullDisk, IsFreedByRemovingAScene) {
  const SmallDisk disk("96m");
  if (!disk.mounted()) GTEST_SKIP() << "this process may not mount";
  StoreLimits limits;
  limits.min_free_disk = std::uint64_t{48} << 20;
  const auto store = std::move(*SqliteStore::open(disk.path() / "store", limits));
  const SceneId scene = tests::make_scene(*store, "a");
  std::string reason;
  const std::uint64_t last = append_until_full(*store, scene, reason);
  EXPECT_EQ(reason, "DISK_FULL");
  const Status removed = store->remove_scene(scene);
  ASSERT_TRUE(removed.ok()) << removed.error().message;
  auto next = store->create_scene({.name = "b"});
  // Its rows are purged, and pages returned, step by step.
  for (int i = 0; i < 10'000 && tests::reason_of(next) == "DISK_FULL"; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    next = store->create_scene({.name = "b"});
  }
  ASSERT_TRUE(next.ok()) << next.error().message;
  EXPECT_GT(append_until_full(*store, *next, reason), last / 2);
  EXPECT_EQ(reason, "DISK_FULL");
}

}  // namespace
}  // namespace sightline::server::store

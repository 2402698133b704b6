// Each call of the file system fails in turn: nothing that was acknowledged is lost, and the store
// goes on.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <map>
#include <set>

#include "server/store/doctor.h"
#include "tests/server/store/directory.h"
#include "tests/server/store/failing_files.h"
#include "tests/server/store/store_steps.h"

namespace sightline::server::store {
namespace {

using tests::Directory;
using tests::FailingFiles;

constexpr std::uint64_t kBatches = 4;
constexpr std::uint64_t kSnapshotAt = 3;

/// A writer's work, in steps that are taken again if they fail.
class Work {
 public:
  Work(Store& store, FailingFiles& files) : store_(store), files_(files) {}

  void run() {
    const std::string bytes = tests::blob_bytes(1);
    const auto digest = tests::digest_of_blob(bytes);
    repeat([&] { return create(); });
    repeat([&] {
      const Status stored = tests::store_blob(store_, bytes);
      return !stored && stored.error().reason == "BLOB_STORED" ? Status() : stored;
    });
    for (std::uint64_t i = 0; i < kBatches; ++i) repeat([&] { return append(i, digest); });
    repeat([&] {
      const Status put = tests::put_snapshot(store_, scene_, kSnapshotAt, {"one", "two"}, {digest});
      return !put && put.error().reason == "SNAPSHOT_EXISTS" ? Status() : put;
    });
    repeat([&] { return store_.drop_before(scene_, kSnapshotAt); });
    repeat([&] { return append(kBatches, digest); });
    repeat([&] {
      const auto loaded = tests::load_blob(store_, digest);
      if (!loaded) return Status(loaded.error());
      EXPECT_EQ(*loaded, bytes);
      return Status();
    });
    repeat([&] {
      const auto swept = store_.sweep(std::chrono::seconds(0), {});
      return swept ? Status() : Status(swept.error());
    });
  }

  /// Reasons of the errors that were met.
  const std::set<std::string>& reasons() const { return reasons_; }

 private:
  template <class Step>
  void repeat(const Step& step) {
    for (int i = 0; i < 3; ++i) {
      const Status done = step();
      if (done) return;
      reasons_.insert(done.error().reason);
      EXPECT_FALSE(done.error().message.empty());
      files_.heal();
    }
    FAIL() << "the store is not usable after " << files_.failed();
  }

  /// A step that failed may have been done all the same.
  Status create() {
    const auto made = store_.create_scene({.name = "a"});
    if (made) {
      scene_ = *made;
      return {};
    }
    if (made.error().reason != "SCENE_EXISTS") return made.error();
    const auto scenes = store_.scenes();
    if (!scenes) return scenes.error();
    scene_ = scenes->front().id;
    return {};
  }

  Status append(std::uint64_t expected, const blobs::BlobDigest& digest) {
    const Status done = tests::append(store_, scene_, expected, "updates", {digest});
    if (done || done.error().reason != "REVISION_MISMATCH") return done;
    const auto record = store_.scene(scene_);
    if (!record) return record.error();
    return record->revision == expected + 1 ? Status() : done;
  }

  Store& store_;
  FailingFiles& files_;
  SceneId scene_ = 0;
  std::set<std::string> reasons_;
};

/// Everything that was acknowledged is there, and nothing is damaged.
void expect_whole(const std::filesystem::path& directory) {
  {
    const auto store = tests::open_store(directory);
    ASSERT_NE(store, nullptr);
    const auto scenes = store->scenes();
    ASSERT_TRUE(scenes.ok());
    ASSERT_EQ(scenes->size(), 1u);
    const SceneRecord& scene = scenes->front();
    EXPECT_EQ(scene.revision, kBatches + 1);
    EXPECT_EQ(scene.base, kSnapshotAt);
    EXPECT_EQ(*store->read_snapshot(scene.id, kSnapshotAt, 0), "one");
    EXPECT_EQ(*store->read_snapshot(scene.id, kSnapshotAt, 1), "two");
    EXPECT_EQ(tests::log_of(*store, scene.id, kSnapshotAt)->size(), kBatches + 1 - kSnapshotAt);
    const std::string bytes = tests::blob_bytes(1);
    EXPECT_EQ(*tests::load_blob(*store, tests::digest_of_blob(bytes)), bytes);
  }
  const auto found = examine(local_files(), directory, {});
  ASSERT_TRUE(found.ok()) << found.error().message;
  for (const std::string& finding : found->findings)
    EXPECT_NE(finding.find("nothing is lost"), std::string::npos) << finding;
}

/// Runs the work with one failing call. Returns whether that call was reached; `table` gets what
/// the failure of each kind of call ended in.
bool run_once(const std::filesystem::path& empty_store, int call, int number, bool lasting,
              std::map<std::string, std::set<std::string>>& table) {
  const Directory directory;
  const auto path = directory.path() / "store";
  std::filesystem::copy(empty_store, path, std::filesystem::copy_options::recursive);
  FailingFiles files;
  files.fail(call, number, lasting);
  auto store = SqliteStore::open(path, tests::small_disk(), files);
  std::set<std::string> reasons;
  if (!store) {
    reasons.insert(store.error().reason);
    files.heal();
    store = SqliteStore::open(path, tests::small_disk(), files);
  }
  EXPECT_TRUE(store.ok()) << store.error().message;
  if (!store) return false;
  Work work(**store, files);
  work.run();
  reasons.insert(work.reasons().begin(), work.reasons().end());
  store->reset();
  const std::string failed = files.failed();
  if (!failed.empty()) table[failed].insert(reasons.begin(), reasons.end());
  expect_whole(path);
  return !failed.empty();
}

class EachCallFails : public testing::TestWithParam<std::pair<int, bool>> {};

TEST_P(EachCallFails, AndNothingIsLost) {
  const Directory directory;
  const auto empty = directory.path() / "empty";
  tests::open_store(empty);
  std::map<std::string, std::set<std::string>> table;
  const auto [number, lasting] = GetParam();
  int call = 1;
  while (run_once(empty, call, number, lasting, table)) {
    ASSERT_FALSE(HasFailure()) << "call " << call;
    ++call;
  }
  EXPECT_GT(call, 50);
  for (const auto& [name, reasons] : table) {
    std::string all;
    for (const std::string& reason : reasons) all += " " + reason;
    fmt::print("{:<22}{}\n", name, all);
  }
}

INSTANTIATE_TEST_SUITE_P(Store, EachCallFails,
                         testing::Values(std::pair(EIO, false), std::pair(EIO, true),
                                         std::pair(ENOSPC, false), std::pair(ENOSPC, true)),
                         [](const auto& instance) {
                           return fmt::format("{}{}", instance.param.first == EIO ? "Io" : "Full",
                                              instance.param.second ? "Lasting" : "Once");
                         });

TEST(StoreFaults, ADirectoryThatCouldNotBeMadeCanBeMadeLater) {
  for (int call = 1;; ++call) {
    const Directory directory;
    FailingFiles files;
    files.fail(call, EIO, false);
    const auto failed = SqliteStore::open(directory.path() / "new", tests::small_disk(), files);
    if (files.failed().empty()) break;
    if (failed) continue;
    EXPECT_EQ(tests::reason_of(failed), "STORE_IO")
        << files.failed() << ": " << failed.error().message;
    files.heal();
    EXPECT_NE(tests::open_store(directory.path() / "new", files), nullptr) << files.failed();
    call += call > 40 && call < 280 ? 60 : 0;  // most calls make one folder each
  }
}

TEST(StoreFaults, ADirectoryThatIsReadOnlyIsNamed) {
  const Directory directory;
  FailingFiles files;
  files.fail(2, EROFS, false);
  const auto refused = SqliteStore::open(directory.path(), tests::small_disk(), files);
  ASSERT_EQ(tests::reason_of(refused), "STORE_READ_ONLY");
  EXPECT_NE(refused.error().message.find(directory.path().string()), std::string::npos);
}

}  // namespace
}  // namespace sightline::server::store

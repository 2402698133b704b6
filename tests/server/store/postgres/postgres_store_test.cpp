// Several servers with one store in PostgreSQL, and what its address may say.
#include <gtest/gtest.h>

#include <future>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/store/postgres/address.h"
#include "server/store/postgres/connection.h"
#include "server/store/postgres/lease.h"
#include "tests/server/store/postgres/postgres_test.h"

namespace sightline::server::store::postgres {
namespace {

using tests::append;
using tests::blob_bytes;
using tests::digest_of_blob;
using tests::log_of;
using tests::make_scene;
using tests::Process;
using tests::reason_of;
using tests::store_blob;

using Strings = std::vector<std::string>;

constexpr std::chrono::seconds kNoGrace{0};

class SharedStore : public tests::PostgresTest {};

TEST_F(SharedStore, OneOfTwoWritersOfARevisionIsRefused) {
  const auto one = open();
  const auto two = two_.open(uri());
  const SceneId scene = make_scene(*one, "a");
  EXPECT_EQ(two->scenes()->front().id, scene);
  EXPECT_EQ(reason_of(two->create_scene({.name = "a"})), "SCENE_EXISTS");
  ASSERT_TRUE(append(*one, scene, 0, "first").ok());
  EXPECT_EQ(reason_of(append(*two, scene, 0, "other")), "REVISION_MISMATCH");
  EXPECT_EQ(two->read(scene, 0, 1000)->front().updates, "first");
  EXPECT_TRUE(append(*two, scene, 1, "second").ok());
  EXPECT_EQ(*log_of(*one, scene), (Strings{"first", "second"}));
}

TEST_F(SharedStore, ProcessesCommitWithoutGaps) {
  const auto one = open();
  const auto two = two_.open(uri());
  const std::vector<SceneId> scenes{make_scene(*one, "a"), make_scene(*one, "b")};
  constexpr std::uint64_t kBatches = 30;
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      Store& store = i % 2 == 0 ? *one : *two;
      const SceneId scene = scenes[static_cast<std::size_t>(i / 2)];
      for (std::uint64_t done = 0; done < kBatches;) {
        const std::uint64_t revision = store.scene(scene)->revision;
        const Status committed = append(store, scene, revision, std::to_string(i));
        EXPECT_TRUE(committed || reason_of(committed) == "REVISION_MISMATCH")
            << committed.error().message;
        done += committed ? 1 : 0;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const SceneId scene : scenes) EXPECT_EQ(log_of(*one, scene)->size(), 2 * kBatches);
}

TEST_F(SharedStore, TellsWhichScenesOthersHaveChanged) {
  const auto one = open();
  const auto two = two_.open(uri());
  const SceneId scene = make_scene(*one, "a");
  std::promise<void> heard;
  std::promise<void> polled;
  std::once_flag heard_once;
  std::once_flag polled_once;
  two->watch([&](std::span<const SceneId> changed) {
    if (changed.empty()) std::call_once(polled_once, [&] { polled.set_value(); });
    if (changed.size() == 1 && changed[0] == scene)
      std::call_once(heard_once, [&] { heard.set_value(); });
  });
  polled.get_future().wait();
  ASSERT_TRUE(append(*one, scene, 0, "first").ok());
  heard.get_future().wait();
  EXPECT_TRUE(two->shared());
}

TEST_F(SharedStore, OneProcessHasALease) {
  const auto store = open();
  const auto address = Address::parse(uri());
  const auto connection = std::move(*Connection::open(*address));
  EXPECT_TRUE(*take_lease(*connection, "test", "one"));
  EXPECT_FALSE(*take_lease(*connection, "test", "two"));
  EXPECT_TRUE(*take_lease(*connection, "test", "one")) << "renewed";
  ASSERT_TRUE(release_lease(*connection, "test", "two").ok());
  EXPECT_FALSE(*take_lease(*connection, "test", "two"));
  ASSERT_TRUE(release_lease(*connection, "test", "one").ok());
  EXPECT_TRUE(*take_lease(*connection, "test", "two"));
  run("UPDATE lease SET expires = expires - 100000 WHERE name = 'test'");
  EXPECT_TRUE(*take_lease(*connection, "test", "one")) << "as that of a process that has died";
}

TEST_F(SharedStore, LeavesTheSnapshotsOfLivingProcesses) {
  const auto one = open();
  const SceneId scene = make_scene(*one, "a");
  ASSERT_TRUE(append(*one, scene, 0, "u").ok());
  Process::Pointer two;
  int calls = 0;
  const Status put = one->put_snapshot(scene, 1, {}, [&]() -> Result<std::string> {
    if (++calls == 1) two = two_.open(uri());
    return calls < 3 ? std::string("chunk") : std::string();
  });
  EXPECT_TRUE(put.ok());
  EXPECT_EQ(*two->read_snapshot(scene, 1, 1), "chunk");
}

TEST_F(SharedStore, PurgesWhatWasRemoved) {
  const auto one = open();
  const auto two = two_.open(uri());
  const SceneId scene = make_scene(*one, "a");
  ASSERT_TRUE(store_blob(*one, blob_bytes(1)).ok());
  ASSERT_TRUE(append(*one, scene, 0, "u", {digest_of_blob(blob_bytes(1))}).ok());
  ASSERT_TRUE(two->remove_scene(scene).ok());
  EXPECT_EQ(reason_of(one->scene(scene)), "SCENE_NOT_FOUND");
  // Whichever of both has the lease.
  while (run("SELECT count(*) FROM batch") != "0") (void)two->sweep(kNoGrace, {});
  while (run("SELECT count(*) FROM content") != "0") {
    (void)one->sweep(kNoGrace, {});
    (void)two->sweep(kNoGrace, {});
  }
  EXPECT_EQ(run("SELECT count(*) FROM scene"), "0");
  EXPECT_FALSE(one->has_blob(digest_of_blob(blob_bytes(1))));
}

TEST_F(SharedStore, FindsDamagedUpdates) {
  const auto store = open();
  const SceneId scene = make_scene(*store, "a");
  ASSERT_TRUE(append(*store, scene, 0, "first").ok());
  run("UPDATE batch SET updates = 'other'");
  EXPECT_EQ(reason_of(store->read(scene, 0, 1000)), "STORE_CORRUPT");
}

TEST_F(SharedStore, RefusesTablesThatAreNotItsOwn) {
  run("CREATE TABLE scene(id INTEGER)");
  EXPECT_EQ(reason_of(PostgresStore::open(uri(), one_.cache.path())), "NOT_A_STORE");
  run("DROP TABLE scene");
  (void)open();
  run("UPDATE sightline_store SET version = 99");
  EXPECT_EQ(reason_of(PostgresStore::open(uri(), one_.cache.path())), "STORE_NEWER");
}

TEST_F(SharedStore, MakesTablesOnce) {
  std::vector<std::future<Process::Pointer>> opening;
  std::vector<Process> processes(4);
  for (const Process& process : processes)
    opening.push_back(std::async(std::launch::async, [&] { return process.open(uri()); }));
  for (auto& one : opening) EXPECT_NE(one.get(), nullptr);
}

TEST(PostgresStore, ShowsNoPassword) {
  const auto refused =
      PostgresStore::open("postgresql://user:hidden@127.0.0.1:1,127.0.0.1:2/db", {});
  ASSERT_EQ(reason_of(refused), "STORE_IO");
  EXPECT_NE(refused.error().message.find("postgresql://user@127.0.0.1:1,127.0.0.1:2/db"),
            std::string::npos);
  EXPECT_EQ(refused.error().message.find("hidden"), std::string::npos);
  for (const char* wrong :
       {"postgresql://user:hidden%@host/db", "hidden", "postgresql://u:hidden@h/d?x=hidden"}) {
    const auto bad = PostgresStore::open(wrong, {});
    ASSERT_EQ(reason_of(bad), "BAD_STORE") << wrong;
    EXPECT_EQ(bad.error().message.find("hidden"), std::string::npos) << bad.error().message;
  }
}

TEST(PostgresAddress, HidesPasswords) {
  EXPECT_EQ(hide_password("postgresql://u:hidden@h:1,i:2/d?sslmode=require"),
            "postgresql://u@h:1,i:2/d?sslmode=require");
  EXPECT_EQ(hide_password("postgresql:///d?host=/run&user=u"), "postgresql:///d?host=/run&user=u");
  EXPECT_EQ(hide_password("postgresql://u@h/d?pass%77ord=hidden"), "postgresql://u@h/d");
  EXPECT_EQ(hide_password("postgresql://u@h/d?sslpassword=hidden"), "postgresql://u@h/d");
  EXPECT_EQ(hide_password("postgresql://u:hid:den%"), "postgresql://...");
  EXPECT_EQ(hide_password("hidden"), "postgresql://...");
}

TEST(PostgresConnection, NumbersParameters) {
  EXPECT_EQ(number_parameters("SELECT ?, ?"), "SELECT $1, $2");
  EXPECT_EQ(number_parameters("SELECT ?2, ?1 WHERE a = 12"), "SELECT $2, $1 WHERE a = 12");
}

}  // namespace
}  // namespace sightline::server::store::postgres

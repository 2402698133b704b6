// Connections to PostgreSQL that are lost, at the worst moments: nothing that was acknowledged is
// lost, and nothing is done twice.
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/store/postgres/cutting_proxy.h"
#include "tests/server/store/postgres/postgres_test.h"
#include "tests/support/sleep_shortly.h"

namespace sightline::server::store::postgres {
namespace {

using tests::append;
using tests::Cut;
using tests::CuttingProxy;
using tests::log_of;
using tests::make_scene;
using tests::PostgresServer;
using tests::reason_of;

using Strings = std::vector<std::string>;

class LostConnections : public tests::PostgresTest {};

TEST_F(LostConnections, AnUnheardCommitIsKeptAndNotRepeated) {
  CuttingProxy proxy(server().socket());
  const auto store = one_.open(PostgresServer::uri(database_, proxy.sockets()));
  const SceneId scene = make_scene(*store, "a");
  proxy.cut(Cut::kAfterCommit);
  EXPECT_TRUE(append(*store, scene, 0, "first").ok());
  EXPECT_TRUE(proxy.has_cut());
  EXPECT_EQ(*log_of(*store, scene), Strings{"first"});
  EXPECT_TRUE(append(*store, scene, 1, "second").ok());
}

TEST_F(LostConnections, ACommitThatDidNotArriveIsRepeated) {
  CuttingProxy proxy(server().socket());
  const auto store = one_.open(PostgresServer::uri(database_, proxy.sockets()));
  const SceneId scene = make_scene(*store, "a");
  proxy.cut(Cut::kBeforeCommit);
  EXPECT_TRUE(append(*store, scene, 0, "first").ok());
  EXPECT_TRUE(proxy.has_cut());
  EXPECT_EQ(*log_of(*store, scene), Strings{"first"});
  EXPECT_TRUE(append(*store, scene, 1, "second").ok());
}

TEST_F(LostConnections, ACommitWithoutAServerIsDecidedWhenOneIsBack) {
  for (const Cut cut : {Cut::kAfterCommit, Cut::kBeforeCommit}) {
    CuttingProxy proxy(server().socket());
    const auto store = one_.open(PostgresServer::uri(database_, proxy.sockets()));
    const SceneId scene = make_scene(*store, cut == Cut::kAfterCommit ? "after" : "before");
    proxy.refuse(true);
    proxy.cut(cut);
    std::promise<Status> first;
    ASSERT_TRUE(store
                    ->append({scene, 0, "first", {}, {}, {}},
                             [&](const Status& done) { first.set_value(done); })
                    .ok());
    while (!proxy.has_cut()) tests::sleep_shortly();
    // Until the writer notices, batches are queued, or there are too many.
    Status refused;
    do {
      tests::sleep_shortly();
      refused = store->append({scene, 1, "second", {}, {}, {}}, [](const Status&) {});
    } while (refused || reason_of(refused) == "TOO_MANY_COMMITS");
    EXPECT_EQ(reason_of(refused), "STORE_IO");
    EXPECT_EQ(reason_of(store->writable()), "STORE_IO");
    proxy.refuse(false);
    EXPECT_TRUE(first.get_future().get().ok());
    store->flush();
    // What reads fails at once for a while if it could not connect meanwhile.
    while (!store->writable().ok()) tests::sleep_shortly();
    EXPECT_EQ(log_of(*store, scene)->front(), "first");
  }
}

TEST_F(LostConnections, AStoreThatEndsSaysThatItDoesNotKnow) {
  CuttingProxy proxy(server().socket());
  auto store = one_.open(PostgresServer::uri(database_, proxy.sockets()));
  const SceneId scene = make_scene(*store, "a");
  proxy.refuse(true);
  proxy.cut(Cut::kAfterCommit);
  std::promise<Status> first;
  ASSERT_TRUE(store
                  ->append({scene, 0, "first", {}, {}, {}},
                           [&](const Status& done) { first.set_value(done); })
                  .ok());
  while (!proxy.has_cut()) tests::sleep_shortly();
  store.reset();
  EXPECT_EQ(reason_of(first.get_future().get()), "OUTCOME_UNKNOWN");
  EXPECT_EQ(*log_of(*open(), scene), Strings{"first"});
}

TEST_F(LostConnections, GoesOnWhenTheServerIsBack) {
  PostgresServer mine;
  const std::string database = mine.make_database();
  const auto store = one_.open(mine.uri(database));
  const SceneId scene = make_scene(*store, "a");
  ASSERT_TRUE(append(*store, scene, 0, "first").ok());
  mine.kill();
  EXPECT_EQ(reason_of(append(*store, scene, 1, "lost")), "STORE_IO");
  EXPECT_EQ(reason_of(store->read(scene, 0, 1)), "STORE_IO");
  EXPECT_EQ(reason_of(store->writable()), "STORE_IO");
  mine.start();
  EXPECT_TRUE(append(*store, scene, 1, "second").ok());
  while (!store->writable()) tests::sleep_shortly();
  EXPECT_EQ(*log_of(*store, scene), (Strings{"first", "second"}));
}

TEST_F(LostConnections, APromotedStandbyHasAllThatWasAcknowledged) {
  PostgresServer primary;
  const std::string database = primary.make_database();
  const PostgresServer standby(primary);
  const auto store = one_.open(
      PostgresServer::uri(database, primary.sockets().string() + "," + standby.sockets().string()));
  const SceneId scene = make_scene(*store, "a");
  constexpr std::uint64_t kBatches = 100;
  std::atomic<std::uint64_t> acknowledged{0};
  std::thread writer([&] {
    while (acknowledged < kBatches) {
      const Status done = append(*store, scene, acknowledged, std::to_string(acknowledged));
      EXPECT_TRUE(done || reason_of(done) == "STORE_IO") << done.error().message;
      if (done) ++acknowledged;
    }
  });
  while (acknowledged < kBatches / 2) tests::sleep_shortly();
  primary.kill();
  EXPECT_EQ(reason_of(store->writable()), "STORE_IO");
  standby.promote();
  writer.join();
  // Reads fail at once for a while, as the one above could not connect.
  while (!store->writable()) tests::sleep_shortly();
  const auto log = log_of(*store, scene);
  ASSERT_TRUE(log) << log.error().message;
  ASSERT_EQ(log->size(), kBatches);
  for (std::uint64_t i = 0; i < kBatches; ++i) EXPECT_EQ((*log)[i], std::to_string(i));
}

}  // namespace
}  // namespace sightline::server::store::postgres

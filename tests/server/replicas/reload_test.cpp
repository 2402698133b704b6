// A scene that a server cannot follow any more, as the log begins later: it is read anew.
#include <gtest/gtest.h>

#include <filesystem>
#include <future>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "scenegraph/model/update.h"
#include "server/durable/store_catalog.h"
#include "server/scenes/scene_store.h"
#include "server/store/postgres/postgres_store.h"
#include "tests/scenegraph/put_node.h"
#include "tests/server/store/directory.h"
#include "tests/server/store/postgres/postgres_server.h"

namespace sightline::tests {
namespace {

using scenegraph::model::Update;
using server::scenes::StoredScene;
using server::store::postgres::PostgresStore;

/// What a server has of scenes; it hears of others only when it is calls to.
struct Member {
  explicit Member(const std::string& uri)
      : store(open(uri, cache.path())),
        blobs(memory, {}, store.get()),
        catalog({*store, blobs, compute}, replica),
        scenes(memory, &catalog) {
    EXPECT_TRUE(scenes.open());
  }
  ~Member() { store->flush(); }

  /// Throws, and so fails the test, if the store cannot be opened.
  static std::unique_ptr<PostgresStore> open(const std::string& uri,
                                             const std::filesystem::path& cache) {
    auto opened = PostgresStore::open(uri, cache);
    if (!opened) throw std::runtime_error(opened.error().message);
    return std::move(*opened);
  }

  std::shared_ptr<StoredScene> scene(const std::string& name) {
    const auto found = scenes.get(name);
    EXPECT_TRUE(found);
    EXPECT_TRUE((*found)->load(compute));
    return *found;
  }
  void apply(StoredScene& scene, std::vector<Update> updates) {
    std::promise<bool> kept;
    scene.write_queue().post(compute, [&] {
      const auto answer = [&](const auto& result) { kept.set_value(result.ok()); };
      if (!scene.apply(std::move(updates), compute, {}, {.answer = answer})) kept.set_value(false);
    });
    EXPECT_TRUE(kept.get_future().get());
  }
  Status follow(StoredScene& scene) {
    std::promise<Status> followed;
    scene.follower()->ask(compute, [&](const Status& read) { followed.set_value(read); });
    return followed.get_future().get();
  }

  Directory cache;
  server::exec::MemoryAccount memory{std::uint64_t{1} << 30};
  std::unique_ptr<PostgresStore> store;
  server::blobs::BlobStore blobs;
  server::exec::Compute compute{2};
  std::shared_ptr<server::scenes::Replica> replica = std::make_shared<server::scenes::Replica>();
  server::durable::StoreCatalog catalog;
  server::scenes::SceneStore scenes;
};

/// Nodes with long names: about a MiB of updates.
std::vector<Update> long_batch() {
  std::vector<Update> updates;
  for (int i = 1; i <= 1200; ++i) {
    Update update = put_node(-i, 0, nullptr);
    std::get<scenegraph::model::PutNode>(update).name = std::string(1000, 'n');
    updates.push_back(std::move(update));
  }
  return updates;
}

TEST(ReplicaReload, AScene) {
  if (!PostgresServer::installed()) GTEST_SKIP() << "PostgreSQL is not installed";
  PostgresServer& postgres = PostgresServer::shared();
  const std::string uri = postgres.uri(postgres.make_database());
  const std::string name = "projects/p/scenes/s";
  Member one(uri);
  const auto made = *one.scenes.create({.name = name});
  one.apply(*made, {put_node(-1, 0, nullptr)});
  Member two(uri);
  const auto followed = two.scene(name);
  int calls = 0;
  followed->events().subscribe([&] { ++calls; });
  ASSERT_EQ(followed->snapshot()->revision(), 1u);
  const auto base = [&] { return one.store->scene(made->number())->base; };
  while (base() < 2) {  // one snapshot after the other, until the first revisions are not readable
    one.apply(*made, long_batch());
    for (int i = 0; i < 70; ++i) one.apply(*made, {});
  }
  ASSERT_TRUE(two.follow(*followed));
  EXPECT_EQ(two.replica->tallies.scenes_reloaded, 1u);
  EXPECT_GT(calls, 0);
  const auto expected = made->snapshot(), now = followed->snapshot();
  EXPECT_EQ(now->revision(), expected->revision());
  EXPECT_EQ(now->node_count(), expected->node_count());
  EXPECT_EQ(followed->log().last(), now->revision());
  EXPECT_FALSE(followed->log().find(2)) << "a watch is calls that it has missed revisions";
  two.apply(*followed, {put_node(-1, 1, nullptr)});
  ASSERT_TRUE(one.follow(*made));
  EXPECT_EQ(made->snapshot()->node_count(), expected->node_count() + 1);
}

}  // namespace
}  // namespace sightline::tests

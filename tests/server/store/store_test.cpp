// A store of each engine: what is kept over a restart, in which order, and what is refused.
#include "server/store/store.h"

#include <gtest/gtest.h>

#include <future>
#include <thread>

#include "tests/server/store/store_kinds.h"
#include "tests/server/store/store_steps.h"

namespace sightline::server::store {
namespace {

using tests::append;
using tests::blob_bytes;
using tests::digest_of_blob;
using tests::log_of;
using tests::make_scene;
using tests::put_snapshot;
using tests::reason_of;
using tests::store_blob;
using tests::StoreTest;

using Strings = std::vector<std::string>;

TEST_P(StoreTest, KeepsScenesOverARestart) {
  const SceneInfo city{"projects/p/scenes/city", 18446744073709551615ull, UpAxis::kZ, 0.01};
  auto store = open();
  ASSERT_TRUE(store->create_scene({.name = "projects/p/scenes/z"}).ok());
  const auto id = store->create_scene(city);
  ASSERT_TRUE(id.ok());
  ASSERT_TRUE(append(*store, *id, 0, "first").ok());
  store.reset();

  store = open();
  const auto scenes = store->scenes();
  ASSERT_TRUE(scenes.ok());
  ASSERT_EQ(scenes->size(), 2u);
  const SceneRecord& kept = scenes->front();
  EXPECT_EQ(kept.id, *id);
  EXPECT_EQ(kept.info.name, city.name);
  EXPECT_EQ(kept.info.incarnation, city.incarnation);
  EXPECT_EQ(kept.info.up_axis, UpAxis::kZ);
  EXPECT_EQ(kept.info.meters_per_unit, 0.01);
  EXPECT_EQ(kept.revision, 1u);
  EXPECT_EQ(kept.log_bytes, 5u);
  EXPECT_EQ(kept.base, 0u);
}

TEST_P(StoreTest, RefusesASecondSceneOfAName) {
  const auto store = open();
  make_scene(*store, "a");
  EXPECT_EQ(reason_of(store->create_scene({.name = "a"})), "SCENE_EXISTS");
}

TEST_P(StoreTest, RemovesAScene) {
  const auto store = open();
  const SceneId scene = make_scene(*store, "a");
  ASSERT_TRUE(append(*store, scene, 0, "first").ok());
  ASSERT_TRUE(store->remove_scene(scene).ok());
  EXPECT_EQ(reason_of(store->remove_scene(scene)), "SCENE_NOT_FOUND");
  EXPECT_EQ(reason_of(store->read(scene, 0, 1)), "SCENE_NOT_FOUND");
  EXPECT_EQ(reason_of(append(*store, scene, 1, "second")), "SCENE_NOT_FOUND");
  const SceneId again = make_scene(*store, "a");
  EXPECT_NE(again, scene);
  EXPECT_EQ(*log_of(*store, again), Strings{});
}

TEST_P(StoreTest, ReadsTheLogInBoundedParts) {
  const auto store = open();
  const SceneId scene = make_scene(*store, "a");
  for (std::uint64_t i = 0; i < 10; ++i)
    ASSERT_TRUE(append(*store, scene, i, std::string(100, static_cast<char>('a' + i))).ok());
  const auto part = store->read(scene, 2, 350);
  ASSERT_TRUE(part.ok());
  ASSERT_EQ(part->size(), 3u);
  EXPECT_EQ(part->front().revision, 3u);
  EXPECT_EQ(part->back().updates, std::string(100, 'e'));
  EXPECT_EQ(store->read(scene, 2, 1)->size(), 1u) << "at least one";
  EXPECT_EQ(store->read(scene, 10, 1000)->size(), 0u);
}

TEST_P(StoreTest, FailsWhatBuildsOnAFailedBatch) {
  const auto store = open();
  const SceneId scene = make_scene(*store, "a");
  const SceneId other = make_scene(*store, "b");
  std::vector<std::string> reasons(4);
  const auto record = [&](std::size_t i) {
    return [&reasons, i](const Status& done) { reasons[i] = reason_of(done); };
  };
  const auto missing = digest_of_blob("never stored");
  ASSERT_TRUE(store->append({scene, 0, "1", {}, {}, {}}, record(0)).ok());
  ASSERT_TRUE(store->append({scene, 1, "2", {missing}, {}, {}}, record(1)).ok());
  ASSERT_TRUE(store->append({scene, 2, "3", {}, {}, {}}, record(2)).ok());
  ASSERT_TRUE(store->append({other, 0, "x", {}, {}, {}}, record(3)).ok());
  store->flush();
  EXPECT_EQ(reasons, (Strings{"", "BLOB_NOT_STORED", "REVISION_MISMATCH", ""}));
  EXPECT_EQ(*log_of(*store, scene), Strings{"1"});
  EXPECT_EQ(*log_of(*store, other), Strings{"x"});
}

TEST_P(StoreTest, FailsWhatBuildsOnALostBatchEvenWhereTheRevisionIsThere) {
  const auto store = open();
  const SceneId scene = make_scene(*store, "a");
  ASSERT_TRUE(append(*store, scene, 0, "of another").ok());
  std::vector<std::string> reasons(4);
  std::shared_ptr<BatchOutcome> before;
  const auto queue = [&](std::uint64_t expected, std::size_t i) {
    Batch batch{scene, expected, std::to_string(i), {}, {}, {}};
    batch.after = std::exchange(before, std::make_shared<BatchOutcome>());
    batch.outcome = before;
    const auto record = [&reasons, i](const Status& done) { reasons[i] = reason_of(done); };
    ASSERT_TRUE(store->append(std::move(batch), record).ok());
  };
  queue(0, 0);
  queue(1, 1);  // it expects what is there, but means the one before
  before = nullptr;
  queue(1, 2);
  queue(2, 3);
  store->flush();
  EXPECT_EQ(reasons, (Strings{"REVISION_MISMATCH", "REVISION_MISMATCH", "", ""}));
  EXPECT_EQ(*log_of(*store, scene), (Strings{"of another", "2", "3"}));
}

TEST_P(StoreTest, FindsSingleRows) {
  const auto store = open();
  const SceneId scene = make_scene(*store, "a");
  const SceneId other = make_scene(*store, "b");
  Batch batch{scene, 0, "1", {}, {}, {}};
  batch.answer = RequestAnswer{"id", 7, 1, {5, 6}};
  batch.commits = {{"robot", 3, {5}}, {"robot", 4, {}}};
  ASSERT_TRUE(append(*store, batch).ok());
  const auto heads = store->heads();
  ASSERT_EQ(heads->size(), 2u);
  EXPECT_EQ((*heads)[0].id, scene);
  EXPECT_EQ((*heads)[0].revision, 1u);
  EXPECT_EQ((*heads)[1].revision, 0u);
  EXPECT_EQ((*store->find_scene("b"))->id, other);
  EXPECT_FALSE(*store->find_scene("c"));
  const auto answer = *store->answer(scene, "id");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->content, 7u);
  EXPECT_EQ(answer->nodes, (std::vector<NodeId>{5, 6}));
  EXPECT_FALSE(*store->answer(other, "id"));
  const auto producer = *store->producer(scene, "robot");
  ASSERT_TRUE(producer);
  EXPECT_EQ(producer->last_committed, 4u);
  ASSERT_EQ(producer->recent.size(), 1u);
  EXPECT_EQ(producer->recent[0].sequence, 3u);
  EXPECT_FALSE(*store->producer(scene, "other"));
  ASSERT_TRUE(store->remove_scene(scene).ok());
  EXPECT_FALSE(*store->find_scene("a"));
  EXPECT_EQ(store->heads()->size(), 1u);
}

TEST_P(StoreTest, CommitsManyThreadsWithoutGaps) {
  auto store = open();
  constexpr int kThreads = 8;
  constexpr std::uint64_t kBatchesEach = 50;
  std::vector<SceneId> scenes;
  for (int i = 0; i < kThreads; ++i) scenes.push_back(make_scene(*store, std::to_string(i)));
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i) {
    threads.emplace_back([&, scene = scenes[static_cast<std::size_t>(i)]] {
      for (std::uint64_t r = 0; r < kBatchesEach; ++r)
        EXPECT_TRUE(append(*store, scene, r, std::to_string(r)).ok());
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(store->figures().batches, kThreads * kBatchesEach);
  EXPECT_EQ(store->figures().batches_in_flight, 0u);
  store = nullptr;
  store = open();
  for (const SceneId scene : scenes) EXPECT_EQ(log_of(*store, scene)->size(), kBatchesEach);
}

TEST_P(StoreTest, KeepsTheLastAnswers) {
  StoreLimits limits = tests::small_disk();
  limits.answers = 3;
  limits.answer_nodes = 10;
  auto store = open(limits);
  const SceneId scene = make_scene(*store, "a");
  const auto answer = [&](std::uint64_t revision, std::vector<NodeId> nodes) {
    Batch batch{scene, revision - 1, "u", {}, {}, {}};
    batch.answer = {"id" + std::to_string(revision), 77, revision, std::move(nodes)};
    return append(*store, batch);
  };
  for (std::uint64_t revision = 1; revision <= 5; ++revision)
    ASSERT_TRUE(answer(revision, {revision, 9}).ok());
  auto answers = store->answers(scene);
  ASSERT_EQ(answers->size(), 3u);
  EXPECT_EQ(answers->front().request_id, "id3");
  EXPECT_EQ(answers->back().content, 77u);
  EXPECT_EQ(answers->back().revision, 5u);
  EXPECT_EQ(answers->back().nodes, (std::vector<NodeId>{5, 9}));

  ASSERT_TRUE(answer(6, std::vector<NodeId>(20, 1)).ok());
  answers = store->answers(scene);
  ASSERT_EQ(answers->size(), 1u) << "the newest, though it is beyond the limit";
  Batch again{scene, 6, "u", {}, RequestAnswer{"id6", 1, 7, {}}, {}};
  EXPECT_EQ(reason_of(append(*store, again)), "REQUEST_ID_KNOWN");
  EXPECT_EQ(store->scene(scene)->revision, 6u) << "nothing of the refused batch stays";
}

TEST_P(StoreTest, KeepsWhatProducersCommitted) {
  StoreLimits limits = tests::small_disk();
  limits.puts = 2;
  auto store = open(limits);
  const SceneId scene = make_scene(*store, "a");
  Batch coalesced{scene, 0, "u", {}, {}, {{"lidar", 1, {1}}, {"lidar", 2, {2, 3}}}};
  ASSERT_TRUE(append(*store, coalesced).ok());
  const Batch rejected{scene, 1, std::nullopt, {}, {}, {{"lidar", 3, {}}, {"arm", 9, {}}}};
  ASSERT_TRUE(append(*store, rejected).ok());
  EXPECT_EQ(store->scene(scene)->revision, 1u) << "without updates there is no revision";
  ASSERT_TRUE(append(*store, {scene, 1, "u", {}, {}, {{"lidar", 4, {8, 7}}}}).ok());
  store.reset();

  store = open();
  const auto producers = store->producers(scene);
  ASSERT_EQ(producers->size(), 2u);
  EXPECT_EQ(producers->front().name, "arm");
  EXPECT_EQ(producers->front().last_committed, 9u);
  EXPECT_TRUE(producers->front().recent.empty());
  const ProducerRecord& lidar = producers->back();
  EXPECT_EQ(lidar.last_committed, 4u);
  ASSERT_EQ(lidar.recent.size(), 2u);
  EXPECT_EQ(lidar.recent[0].sequence, 2u);
  EXPECT_EQ(lidar.recent[0].nodes, (std::vector<NodeId>{2, 3}));
  EXPECT_EQ(lidar.recent[1].nodes, (std::vector<NodeId>{8, 7}));
  const Batch repeated{scene, 2, "u", {}, {}, {{"lidar", 4, {}}}};
  EXPECT_EQ(reason_of(append(*store, repeated)), "SEQUENCE_KNOWN");
}

TEST_P(StoreTest, ContinuesTheLogAfterASnapshot) {
  auto store = open();
  const SceneId scene = make_scene(*store, "a");
  for (std::uint64_t i = 0; i < 6; ++i) ASSERT_TRUE(append(*store, scene, i, "0123456789").ok());
  EXPECT_EQ(reason_of(store->drop_before(scene, 4)), "NO_SNAPSHOT");
  ASSERT_TRUE(put_snapshot(*store, scene, 2, {"old"}).ok());
  ASSERT_TRUE(put_snapshot(*store, scene, 4, {"nodes of ", "revision 4"}).ok());
  EXPECT_EQ(reason_of(put_snapshot(*store, scene, 4, {"x"})), "SNAPSHOT_EXISTS");
  EXPECT_EQ(reason_of(put_snapshot(*store, scene, 7, {"x"})), "REVISION_NOT_KEPT");
  ASSERT_TRUE(store->drop_before(scene, 4).ok());
  store.reset();

  store = open();
  const auto record = store->scene(scene);
  EXPECT_EQ(record->base, 4u);
  EXPECT_EQ(record->snapshots, std::vector<std::uint64_t>{4});
  EXPECT_EQ(record->log_bytes, 20u);
  EXPECT_EQ(*store->read_snapshot(scene, 4, 0), "nodes of ");
  EXPECT_EQ(*store->read_snapshot(scene, 4, 1), "revision 4");
  EXPECT_EQ(*store->read_snapshot(scene, 4, 2), "");
  EXPECT_EQ(reason_of(store->read_snapshot(scene, 2, 0)), "NO_SNAPSHOT");
  EXPECT_EQ(reason_of(store->read(scene, 3, 1000)), "REVISION_NOT_KEPT");
  EXPECT_EQ(log_of(*store, scene, 4)->size(), 2u);
  EXPECT_EQ(reason_of(put_snapshot(*store, scene, 3, {"x"})), "REVISION_NOT_KEPT");
}

TEST_P(StoreTest, KeepsNothingOfAFailedSnapshot) {
  const auto store = open();
  const SceneId scene = make_scene(*store, "a");
  ASSERT_TRUE(append(*store, scene, 0, "u").ok());
  int calls = 0;
  const Status failed = store->put_snapshot(scene, 1, {}, [&]() -> Result<std::string> {
    if (++calls == 2) return Error{Code::kInternal, "no more", "TEST"};
    return std::string("chunk");
  });
  EXPECT_EQ(reason_of(failed), "TEST");
  EXPECT_TRUE(store->scene(scene)->snapshots.empty());
  EXPECT_TRUE(put_snapshot(*store, scene, 1, {"again"}).ok());
  EXPECT_EQ(reason_of(put_snapshot(*store, scene + 1, 1, {"x"})), "SCENE_NOT_FOUND");
}

TEST_P(StoreTest, ARestoredSceneReplacesAnother) {
  auto store = open();
  const SceneId before = make_scene(*store, "a");
  ASSERT_TRUE(append(*store, before, 0, "u").ok());
  const auto blob = digest_of_blob(blob_bytes(1));
  ASSERT_TRUE(store_blob(*store, blob_bytes(1)).ok());
  const auto restore = [&](std::uint64_t revision, std::vector<std::string> chunks,
                           bool replace = true) {
    return store->restore_scene(
        {.name = "a", .incarnation = 7}, revision, {blob},
        [&, next = std::size_t{0}]() mutable -> Result<std::string> {
          if (next == chunks.size()) return std::string();
          if (chunks[next].empty()) return Error{Code::kInternal, "no more", "TEST"};
          return chunks[next++];
        },
        replace);
  };
  EXPECT_EQ(reason_of(restore(5, {"nodes", ""})), "TEST");
  EXPECT_EQ(reason_of(restore(5, {"nodes"}, false)), "SCENE_EXISTS");
  EXPECT_EQ(store->scenes()->front().id, before) << "nothing has changed";
  const auto id = restore(5, {"nodes ", "at 5"});
  ASSERT_TRUE(id.ok());
  EXPECT_EQ(reason_of(store->scene(before)), "SCENE_NOT_FOUND");
  ASSERT_TRUE(append(*store, *id, 5, "next").ok());
  store.reset();

  store = open();
  ASSERT_EQ(store->scenes()->size(), 1u);
  const SceneRecord kept = store->scenes()->front();
  EXPECT_EQ(kept.id, *id);
  EXPECT_EQ(kept.info.incarnation, 7u);
  EXPECT_EQ(kept.base, 5u);
  EXPECT_EQ(kept.revision, 6u);
  EXPECT_EQ(*store->read_snapshot(*id, 5, 1), "at 5");
  EXPECT_EQ(*log_of(*store, *id, 5), Strings{"next"});
  EXPECT_EQ(store->blobs_of(*id)->size(), 1u);
  const auto empty = restore(0, {"nothing"});
  ASSERT_TRUE(empty.ok());
  EXPECT_EQ(*log_of(*store, *empty), Strings{});
}

TEST_P(StoreTest, RefusesASnapshotOfASceneThatIsRemovedMeanwhile) {
  const auto store = open();
  const SceneId scene = make_scene(*store, "a");
  ASSERT_TRUE(append(*store, scene, 0, "u").ok());
  int calls = 0;
  const Status failed = store->put_snapshot(scene, 1, {}, [&]() -> Result<std::string> {
    ++calls;
    EXPECT_TRUE(calls != 2 || store->remove_scene(scene).ok());
    return calls < 20 ? std::string("chunk") : std::string();
  });
  EXPECT_EQ(reason_of(failed), "SCENE_NOT_FOUND");
}

TEST_P(StoreTest, RefusesBeyondTheLimitsOfALog) {
  StoreLimits limits = tests::small_disk();
  limits.log_revisions = 3;
  limits.log_bytes = 20;
  const auto store = open(limits);
  const SceneId few = make_scene(*store, "few");
  for (std::uint64_t i = 0; i < 3; ++i) ASSERT_TRUE(append(*store, few, i, "u").ok());
  const Status beyond = append(*store, few, 3, "u");
  EXPECT_EQ(reason_of(beyond), "LOG_FULL");
  EXPECT_EQ(beyond.error().message, "log_revisions would be 4, the limit is 3");
  ASSERT_TRUE(put_snapshot(*store, few, 3, {"all"}).ok());
  ASSERT_TRUE(store->drop_before(few, 3).ok());
  EXPECT_TRUE(append(*store, few, 3, "u").ok());

  const SceneId large = make_scene(*store, "large");
  EXPECT_EQ(append(*store, large, 0, std::string(21, 'x')).error().message,
            "log_bytes would be 21, the limit is 20");
}

TEST_P(StoreTest, RefusesMoreThanItsQueueHolds) {
  StoreLimits limits = tests::small_disk();
  limits.batches_in_flight = 2;
  const auto store = open(limits);
  const SceneId scene = make_scene(*store, "a");
  std::promise<void> release;
  const auto held = release.get_future().share();
  const auto wait = [held](const Status&) { held.wait(); };
  ASSERT_TRUE(store->append({scene, 0, "u", {}, {}, {}}, wait).ok());
  // The `done` of the first holds the writer, so that the queue fills.
  std::size_t queued = 1;
  Status refused;
  while (refused && queued < 10) {
    refused = store->append({scene, queued, "u", {}, {}, {}}, [](const Status&) {});
    if (refused) ++queued;
  }
  EXPECT_EQ(reason_of(refused), "TOO_MANY_COMMITS");
  EXPECT_EQ(refused.error().message, "batches_in_flight would be 3, the limit is 2");
  release.set_value();
  store->flush();
  EXPECT_EQ(store->figures().batches_in_flight, 0u);
  EXPECT_EQ(store->scene(scene)->revision, queued);
}

RUN_ON_ALL_ENGINES(StoreTest);

}  // namespace
}  // namespace sightline::server::store

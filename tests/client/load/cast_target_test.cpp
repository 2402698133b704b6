// Requests against a server: casts of every kind, updates between them.
#include "client/load/cast_target.h"

#include <gtest/gtest.h>

#include <numeric>

#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"

namespace sightline::client::load {
namespace {

using State = Outcome::State;

TEST(CastTarget, UpdatesAreSpreadEvenly) {
  for (const double share : {0.0, 0.1, 0.25, 1.0}) {
    std::uint64_t updates = 0;
    for (std::uint64_t k = 0; k < 1000; ++k) {
      if (is_update(k, share)) ++updates;
      EXPECT_NEAR(static_cast<double>(updates), share * static_cast<double>(k + 1), 1);
    }
  }
}

class LiveTarget : public tests::LiveClient {
 protected:
  LiveTarget() {
    const auto uploaded = upload_scene(client_, tests::kScene, tests::row_of_sheets(3), {});
    EXPECT_TRUE(uploaded);
    ClientOptions options;
    options.own_connection = true;
    clients_.push_back(*Client::connect(endpoint(), options));
  }

  static RaySet downward_rays() {
    const tests::DownwardRays rays(10, 3);
    return RaySet::copy(rays.columns());
  }

  Outcome send(QueryKind kind, const std::string& scene = tests::kScene) {
    const RaySet rays = downward_rays();
    CastTarget target(clients_, rays, nullptr, 1,
                      {.scene = scene, .cast = {.kind = kind}, .batch = 6});
    EXPECT_EQ(target.send(0, 1, {}).rays, scene == tests::kScene ? 4u : 0u);
    return target.send(0, 0, {});
  }

  std::vector<Client> clients_;
};

TEST_F(LiveTarget, EveryKindIsAnswered) {
  for (const QueryKind kind :
       {QueryKind::kClosest, QueryKind::kAny, QueryKind::kCount, QueryKind::kAll}) {
    const Outcome outcome = send(kind);
    EXPECT_EQ(outcome.state, State::kAnswered) << outcome.error;
    EXPECT_EQ(outcome.rays, 6u);
    EXPECT_EQ(outcome.hits, 6u);
    EXPECT_FALSE(outcome.is_update);
  }
}

TEST_F(LiveTarget, AnErrorIsAFailureWithItsMessage) {
  const Outcome outcome = send(QueryKind::kClosest, "projects/default/scenes/none");
  EXPECT_EQ(outcome.state, State::kFailed);
  EXPECT_NE(outcome.error, "");
}

TEST_F(LiveTarget, ARequestedStopCancels) {
  std::stop_source stop;
  stop.request_stop();
  const RaySet rays = downward_rays();
  CastTarget target(clients_, rays, nullptr, 1, {.scene = tests::kScene, .cast = {}, .batch = 6});
  EXPECT_EQ(target.send(0, 0, stop.get_token()).state, State::kCancelled);
}

TEST_F(LiveTarget, UpdatesMoveACopyThatGoesAway) {
  const auto before = client_.get_scene(tests::kScene);
  ASSERT_TRUE(before);
  {
    auto copy = MovingCopy::add(client_, tests::kScene);
    ASSERT_TRUE(copy) << copy.error().message;
    EXPECT_EQ(client_.get_scene(tests::kScene)->instances, before->instances + 1);
    const RaySet rays = downward_rays();
    CastTarget target(clients_, rays, &*copy, 1,
                      {.scene = tests::kScene, .cast = {}, .batch = 6, .updates = 0.5});
    const Outcome cast = target.send(0, 0, {}), update = target.send(0, 1, {});
    EXPECT_FALSE(cast.is_update);
    EXPECT_TRUE(update.is_update);
    EXPECT_EQ(update.state, State::kAnswered) << update.error;
    EXPECT_EQ(client_.get_scene(tests::kScene)->revision, before->revision + 2);
  }
  EXPECT_EQ(client_.get_scene(tests::kScene)->instances, before->instances);
}

TEST_F(LiveTarget, ACopyHasTheLabelsOfItsOriginal) {
  const std::uint64_t nodes = client_.get_scene(tests::kScene)->nodes;
  std::vector<std::uint64_t> ids(nodes + 1);
  std::iota(ids.begin(), ids.end(), std::uint64_t{1});
  auto originals = client_.get_nodes(tests::kScene, ids);
  ASSERT_TRUE(originals) << originals.error().message;
  std::vector<Update> labelled;
  for (const NodeInfo& node : *originals) {
    if (node.id == 0 || node.mesh_digest.empty()) continue;
    labelled.emplace_back(PutNode{.node = node.id,
                                  .parent = node.parent,
                                  .mesh_digest = node.mesh_digest,
                                  .labels = {{"class", "IfcDoor"}}});
  }
  ASSERT_TRUE(client_.apply(tests::kScene, labelled));
  const auto copy = MovingCopy::add(client_, tests::kScene);
  ASSERT_TRUE(copy) << copy.error().message;
  const auto copied = client_.get_nodes(tests::kScene, {{nodes + 1}});
  EXPECT_EQ(copied->front().name, MovingCopy::kName);
  EXPECT_EQ(copied->front().labels, (std::vector<Label>{{"class", "IfcDoor"}}));
}

TEST_F(LiveTarget, ACopyThatWasLeftBehindIsReplaced) {
  const auto before = client_.get_scene(tests::kScene);
  PutNode node;
  node.node = -1;
  node.name = MovingCopy::kName;
  const std::vector<Update> left{node};
  ASSERT_TRUE(client_.apply(tests::kScene, left));
  { const auto copy = MovingCopy::add(client_, tests::kScene); }
  EXPECT_EQ(client_.get_scene(tests::kScene)->nodes, before->nodes);
}

TEST_F(LiveTarget, ASceneWithoutInstancesHasNothingToMove) {
  ASSERT_TRUE(client_.create_scene("projects/default/scenes/empty"));
  const auto copy = MovingCopy::add(client_, "projects/default/scenes/empty");
  ASSERT_FALSE(copy);
  EXPECT_EQ(copy.error().reason, "NO_INSTANCE");
}

}  // namespace
}  // namespace sightline::client::load

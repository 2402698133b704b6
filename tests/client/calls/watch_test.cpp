// Watching a scene, from an earlier revision and from now, through broken connections.
#include "client/update.h"

#include <gtest/gtest.h>

#include <stop_token>
#include <string>
#include <vector>

#include "tests/client/support/live_client.h"
#include "tests/client/support/relay.h"

namespace sightline::client::calls {
namespace {

using tests::kScene;

class WatchTest : public tests::LiveClient {
 protected:
  WatchTest() { EXPECT_TRUE(client_.create_scene(kScene)); }

  void put(const std::string& name) {
    PutNode update;
    update.node = -1;
    update.name = name;
    EXPECT_TRUE(client_.apply(kScene, std::vector<Update>{update}));
  }
};

TEST_F(WatchTest, ReportsUpdatesSinceARevision) {
  put("a");
  put("b");
  put("c");
  std::vector<SceneChange> seen;
  const Status watched = client_.watch(kScene, 1, [&](const SceneChange& change) {
    if (!change.is_progress) seen.push_back(change);
    return seen.size() < 2;
  });
  ASSERT_TRUE(watched) << watched.error().message;
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_EQ(seen[0].revision, 2U);
  EXPECT_EQ(seen[1].revision, 3U);
  EXPECT_EQ(seen[1].token, client_.get_scene(kScene)->token);
  ASSERT_EQ(seen[1].updates.size(), 1U);
  EXPECT_EQ(std::get<PutNode>(seen[1].updates[0]).node, 3) << "by its id, not its alias";
  EXPECT_EQ(std::get<PutNode>(seen[1].updates[0]).name, "c");
}

TEST_F(WatchTest, BeginsWithTheNewestRevisionByDefault) {
  put("before");
  bool begun = false;
  const Status watched = client_.watch(kScene, {}, [&](const SceneChange& change) {
    if (!begun) {
      EXPECT_TRUE(change.is_progress);
      EXPECT_EQ(change.revision, 1U);
      begun = true;
      put("after");
      return true;
    }
    if (change.is_progress) return true;
    EXPECT_EQ(change.revision, 2U);
    return false;
  });
  EXPECT_TRUE(watched) << watched.error().message;
}

TEST_F(WatchTest, ContinuesAfterBrokenConnectionsWithoutGaps) {
  tests::Relay relay(server_->port());
  const auto through = Client::connect(relay.endpoint());
  ASSERT_TRUE(through);
  put("1");
  std::uint64_t reached = 0;
  const Status watched = through->watch(kScene, 0, [&](const SceneChange& change) {
    if (change.is_progress) return true;
    EXPECT_EQ(change.revision, reached + 1);
    reached = change.revision;
    if (reached % 2 == 0) relay.cut();
    put("next");
    return reached < 7;
  });
  EXPECT_TRUE(watched) << watched.error().message;
  EXPECT_EQ(reached, 7U);
  EXPECT_GT(relay.connections(), 2);
}

TEST_F(WatchTest, MergesTheMessagesOfOneRevision) {
  std::vector<Update> many;
  for (NodeRef alias = -1; alias >= -20'000; --alias) {
    PutNode put;
    put.node = alias;
    put.name = std::string(100, 'n');
    many.emplace_back(put);
  }
  auto stream = client_.open_update_stream(kScene, "p");
  ASSERT_TRUE(stream);
  ASSERT_TRUE(stream->send(many));
  ASSERT_TRUE(stream->close());
  const Status watched = client_.watch(kScene, 0, [&](const SceneChange& change) {
    if (change.is_progress) return true;
    EXPECT_EQ(change.updates.size(), many.size());
    return false;
  });
  EXPECT_TRUE(watched);
}

TEST_F(WatchTest, IsStopped) {
  std::stop_source stop;
  const Status watched = client_.watch(
      kScene, {},
      [&](const SceneChange&) {
        stop.request_stop();
        return true;
      },
      stop.get_token());
  ASSERT_FALSE(watched);
  EXPECT_EQ(watched.error().code, Code::kCancelled);
}

TEST_F(WatchTest, ReportsWhyASceneCannotBeWatched) {
  const SceneChangeSink none = [](const SceneChange&) { return true; };
  EXPECT_EQ(client_.watch("projects/default/scenes/none", {}, none).error().code, Code::kNotFound);
  EXPECT_EQ(client_.watch(kScene, 99, none).error().code, Code::kOutOfRange);
}

}  // namespace
}  // namespace sightline::client::calls

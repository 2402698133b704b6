// Streams of rays through connections that break, and over replicas.
#include "client/calls/cast_stream.h"

#include <gtest/gtest.h>

#include <array>
#include <set>
#include <vector>

#include "client/client.h"
#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"
#include "tests/client/support/relay.h"

namespace sightline::client::calls {
namespace {

using tests::DownwardRays;
using tests::kScene;

constexpr std::uint32_t kStreamCopies = 3;
constexpr std::size_t kStreamRays = 9 * kRaysPerMessage + 17;

class CastStream : public tests::LiveClient {
 protected:
  CastStream() {
    EXPECT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(kStreamCopies), {}));
  }

  tests::Relay relay_{server_->port()};
  const Client through_ = *Client::connect(relay_.endpoint());
  const DownwardRays rays_{kStreamRays, kStreamCopies};
};

// Hands out the rays in order.
RaySource<double> one_after_the_other(const DownwardRays& rays) {
  return [&rays,
          next = std::size_t{0}](const RayColumns<double>& buffer) mutable -> Result<std::size_t> {
    const std::size_t count = std::min(buffer.size(), rays.columns().size() - next);
    std::copy_n(rays.origins.data() + 3 * next, 3 * count, buffer.origins.begin());
    std::copy_n(rays.directions.data() + 3 * next, 3 * count, buffer.directions.begin());
    next += count;
    return count;
  };
}

TEST_F(CastStream, GoesOnAfterBrokenConnections) {
  std::vector<double> expected(kStreamRays), t(kStreamRays);
  ASSERT_TRUE(client_.cast_stream(kScene, rays_.columns(), {.t = expected}));
  std::uint64_t next = 0;
  const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& hits) {
    EXPECT_EQ(first, next) << "each ray once, in order";
    std::copy_n(hits.t.begin(), count, &t[first]);
    next = first + count;
    if (first / kRaysPerMessage % 3 == 1) relay_.cut();
    return Status();
  };
  const auto report =
      through_.cast_stream(kScene, one_after_the_other(rays_), {}, {.t = true}, sink);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->rays, kStreamRays);
  EXPECT_EQ(next, kStreamRays);
  EXPECT_EQ(t, expected);
  EXPECT_GT(relay_.connections(), 2);
}

TEST_F(CastStream, OfAllHitsGoesOnWithinAMessage) {
  const auto expected = client_.cast_all(kScene, rays_.columns(), {.t = true, .node = true});
  ASSERT_TRUE(expected);
  std::vector<double> t;
  std::vector<std::uint64_t> nodes;
  std::uint64_t next = 0;
  const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& hits) {
    EXPECT_EQ(first, next);
    t.insert(t.end(), hits.t.begin(), hits.t.end());
    nodes.insert(nodes.end(), hits.node.begin(), hits.node.end());
    next = first + count;
    if (first % kRaysPerMessage != 0) relay_.cut();
    return Status();
  };
  const auto report =
      through_.cast_stream(kScene, one_after_the_other(rays_), {}, {.t = true, .node = true}, sink,
                           {.kind = QueryKind::kAll});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(next, kStreamRays);
  EXPECT_EQ(t, expected->t);
  EXPECT_EQ(nodes, expected->node);
}

TEST_F(CastStream, StaysAtTheRevisionOfItsFirstAnswer) {
  const auto before = client_.get_scene(kScene);
  ASSERT_TRUE(before);
  std::size_t hits_seen = 0;
  const HitSink sink = [&](std::uint64_t first, std::size_t, const HitView& hits) -> Status {
    for (const std::uint8_t hit : hits.hit) hits_seen += hit;
    if (first != 0) return {};
    const auto removed = client_.apply(kScene, std::vector<Update>{DeleteNode{1, true}});
    relay_.cut();
    return removed ? Status() : Status(removed.error());
  };
  const auto report =
      through_.cast_stream(kScene, one_after_the_other(rays_), {}, {.hit = true}, sink);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->revision, before->revision);
  EXPECT_EQ(hits_seen, kStreamRays);
}

TEST_F(CastStream, DoesNotMixTwoScenesOfOneName) {
  const HitSink sink = [&](std::uint64_t first, std::size_t, const HitView&) -> Status {
    if (first != 0) return {};
    EXPECT_TRUE(client_.delete_scene(kScene));
    EXPECT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(1), {}));
    relay_.cut();
    return {};
  };
  const auto report =
      through_.cast_stream(kScene, one_after_the_other(rays_), {}, {.t = true}, sink);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, Code::kAborted);
  EXPECT_EQ(report.error().reason, "SCENE_REPLACED");
}

TEST_F(CastStream, ReplicasTakeTurnsAndOneMayGo) {
  const auto other = tests::start_server();
  const std::string second = "127.0.0.1:" + std::to_string(other->port());
  // Another scene of the same name shows who has answered.
  ASSERT_TRUE(upload_scene(*Client::connect(second), kScene, tests::row_of_sheets(0), {}));
  const auto client = Client::connect(endpoint() + "," + second);
  ASSERT_TRUE(client);
  const DownwardRays one(1, 1);
  std::set<int> answers;
  const auto cast = [&] {
    std::array<std::uint8_t, 1> hit{};
    const auto report = client->cast(kScene, one.columns(), {.hit = hit});
    ASSERT_TRUE(report) << report.error().message;
    answers.insert(hit[0]);
  };
  for (int tries = 0; tries < 1000 && answers.size() < 2; ++tries) cast();
  EXPECT_EQ(answers, (std::set<int>{0, 1}));
  stop_server();
  answers.clear();
  for (int i = 0; i < 20; ++i) cast();
  EXPECT_EQ(answers, std::set<int>{0});
}

}  // namespace
}  // namespace sightline::client::calls

// Updates and rays in one call, over a real connection.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include "client/client.h"
#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"
#include "tests/client/support/relay.h"

namespace sightline::client::calls {
namespace {

using tests::DownwardRays;
using tests::kScene;

constexpr std::uint32_t kSheets = 5;
constexpr std::size_t kRays = 200;

/// Sheets of which the upper one, z = 1, is seen from z = 5.
class ApplyAndCast : public tests::LiveClient {
 protected:
  ApplyAndCast() { EXPECT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(kSheets), {})); }

  /// Casts at copy 0, the first ray, and others.
  Result<AppliedCast> cast(const Client& client, const std::vector<Update>& updates,
                           const CastOptions& options = {}, const ApplyOptions& apply = {}) {
    const DownwardRays rays(kRays, kSheets);
    return client.apply_and_cast(kScene, updates, rays.columns(), {.t = t_}, options, apply);
  }

  /// Lifts all sheets.
  static std::vector<Update> lift(double z) {
    SetTransforms set{{1}, {kIdentity}};
    set.parent_from_local[0][11] = z;
    return {set};
  }

  std::vector<double> t_ = std::vector<double>(kRays);
};

TEST_F(ApplyAndCast, TheRaysSeeWhatTheUpdatesMake) {
  for (int z = 1; z <= 3; ++z) {
    const auto done = cast(client_, lift(z));
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(t_, std::vector<double>(kRays, 4 - z));
    EXPECT_EQ(done->applied.revision, static_cast<std::uint64_t>(1 + z));
    EXPECT_EQ(done->cast.revision, done->applied.revision);
    EXPECT_EQ(done->cast.token, done->applied.token);
    EXPECT_FALSE(done->applied.replayed);
    EXPECT_EQ(done->cast.rays, kRays);
    EXPECT_EQ(done->cast.hits, kRays);
  }
  PutNode put;
  put.node = -1;
  const auto none = cast(client_, {put});
  ASSERT_TRUE(none) << none.error().message;
  EXPECT_EQ(none->applied.nodes.size(), 1U);
}

TEST_F(ApplyAndCast, PointsAreMeasuredFromWhatTheUpdatesMake) {
  const std::vector<float> positions{0.75F, 0.5F, 5};
  std::vector<double> t(1);
  const auto done =
      client_.apply_and_nearest(kScene, lift(2), PointColumns<const float>{positions}, {.t = t});
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_EQ(t[0], 2);
  EXPECT_EQ(done->applied.revision, 2U);
  EXPECT_EQ(done->cast.revision, 2U);
  const std::vector<double> doubles{0.75, 0.5, 5};
  ASSERT_TRUE(
      client_.apply_and_nearest(kScene, lift(3), PointColumns<const double>{doubles}, {.t = t}));
  EXPECT_EQ(t[0], 1);
}

TEST_F(ApplyAndCast, ErrorsAreThoseOfBoth) {
  EXPECT_EQ(cast(client_, {DeleteNode{99, false}}).error().code, Code::kNotFound);
  EXPECT_EQ(cast(client_, {SetTransforms{{1, 2}, {kIdentity}}}).error().message,
            "update 0: 2 nodes but 1 transforms");
  EXPECT_EQ(cast(client_, {PatchVertices{{2}, 0, std::vector<Vertex>(100'000)}}).error().code,
            Code::kResourceExhausted);
  EXPECT_EQ(cast(client_, lift(1), {.kind = QueryKind::kAll}).error().code, Code::kInvalidArgument);
  EXPECT_EQ(cast(client_, lift(1), {.consistency = {.exact_revision = 1}}).error().reason,
            "CONSISTENCY_WITH_UPDATES");
  EXPECT_EQ(cast(client_, lift(1), {}, {.expected_revision = 9}).error().code, Code::kAborted);
  EXPECT_EQ(client_.get_scene(kScene)->revision, 1U);
  EXPECT_TRUE(cast(client_, lift(1), {}, {.expected_revision = 1}));
}

TEST_F(ApplyAndCast, ARepeatIsAnsweredAtItsRevision) {
  const auto first = cast(client_, lift(1), {}, {.request_id = "r"});
  ASSERT_TRUE(first) << first.error().message;
  ASSERT_TRUE(cast(client_, lift(2)));
  const auto again = cast(client_, lift(1), {}, {.request_id = "r"});
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_TRUE(again->applied.replayed);
  EXPECT_EQ(again->cast.revision, first->applied.revision);
  EXPECT_EQ(t_.front(), 3);
  const auto applied = client_.apply(kScene, lift(1), {.request_id = "r"});
  ASSERT_TRUE(applied) << applied.error().message;
  EXPECT_TRUE(applied->replayed) << "whichever call it is";
}

TEST_F(ApplyAndCast, IsAppliedOnceThoughConnectionsBreak) {
  tests::Relay relay(server_->port());
  const auto client = Client::connect(relay.endpoint());
  ASSERT_TRUE(client);
  ASSERT_TRUE(cast(*client, lift(0)));
  std::uint64_t revision = 2;
  for (const std::size_t bytes : {300, 900, 2000, 4000}) {
    // Some break on the way to the server, some when the answer comes.
    relay.cut_each_after(0, bytes);
    relay.cut();
    PutNode put;
    put.node = -1;
    const std::string id = "broken-" + std::to_string(bytes);
    static_cast<void>(cast(*client, {put}, {}, {.request_id = id}));
    relay.cut_each_after(0, 0);
    relay.cut();
    const auto again = cast(*client, {put}, {}, {.request_id = id});
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(again->applied.revision, ++revision);
  }
  EXPECT_EQ(client_.get_scene(kScene)->revision, revision);
}

TEST_F(ApplyAndCast, AStopEndsIt) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(cast(client_, lift(1), {.stop = stop.get_token()}).error().code, Code::kCancelled);
}

}  // namespace
}  // namespace sightline::client::calls

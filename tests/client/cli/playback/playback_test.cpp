// Frames on their way: which are sent, which are passed over.
#include "client/cli/playback/playback.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "client/calls/scene_upload.h"
#include "tests/client/support/live_client.h"
#include "tests/client/support/relay.h"

namespace sightline::client::cli::playback {
namespace {

using tests::kScene;

TEST(Percentile, IsOneOfTheValues) {
  EXPECT_EQ(percentile({}, 0.5), 0);
  EXPECT_EQ(percentile({7}, 0.99), 7);
  std::vector<double> hundred;
  for (int i = 1; i <= 100; ++i) hundred.push_back(i);
  EXPECT_EQ(percentile(hundred, 0.5), 50);
  EXPECT_EQ(percentile(hundred, 0.99), 99);
  EXPECT_EQ(percentile(hundred, 1), 100);
}

class Playback : public tests::LiveClient {
 protected:
  Playback() { EXPECT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(1), {})); }

  // Frame k moves the sheet to x = k.
  static std::vector<Update> move(std::uint64_t frame) {
    SetTransforms set{{2}, {kIdentity}};
    set.parent_from_local[0][3] = static_cast<double>(frame);
    return {set};
  }
  double x() {
    return (*client_.get_nodes(kScene, std::vector<std::uint64_t>{2}))[0].parent_from_local[3];
  }

  PlaybackRequest request(std::uint64_t frames, double fps) {
    return {.scene = kScene, .producer = "p", .fps = fps, .frames = frames};
  }
};

TEST_F(Playback, EveryFrameIsAccountedForAndTheLastIsSent) {
  // At such a rate some are late, how many is not ours to say.
  const auto report = play(
      client_, request(500, 20'000), [](std::uint64_t k, bool) { return move(k); },
      [](std::uint64_t) {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->frames_sent + report->frames_late + report->frames_dropped, 500U);
  EXPECT_EQ(report->ack_ms.size(), report->frames_sent);
  EXPECT_EQ(report->stream.revision, 1 + report->frames_sent);
  EXPECT_EQ(report->frames_unchanged, 0U);
  EXPECT_EQ(x(), 499);
}

TEST_F(Playback, FramesOfNothingAreNotSent) {
  const auto report = play(
      client_, request(3, 1000), [](std::uint64_t, bool) { return std::vector<Update>(); },
      [](std::uint64_t) {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->frames_sent, 0U);
  EXPECT_EQ(report->frames_unchanged + report->frames_late, 3U);
  EXPECT_EQ(client_.get_scene(kScene)->revision, 1U);
}

TEST_F(Playback, WhileTheWindowIsFullFramesAreDroppedAndTheNextSaysAll) {
  tests::Relay relay(server_->port());
  const auto through = Client::connect(relay.endpoint());
  ASSERT_TRUE(through);
  int told_afresh = 0;
  bool held = false;
  const auto report = play(
      *through, request(40, 1000),
      [&](std::uint64_t k, bool afresh) {
        // With the first that is shown, which need not be frame 0: that may be late.
        if (!std::exchange(held, true)) relay.hold(true);
        if (k == 39) relay.hold(false);
        if (afresh) ++told_afresh;
        return move(k);
      },
      [&](std::uint64_t) {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->frames_sent + report->frames_late + report->frames_dropped, 40U);
  EXPECT_LE(report->frames_sent, 16U + 1);
  if (report->frames_dropped > 0) {
    EXPECT_EQ(told_afresh, static_cast<int>(report->frames_dropped));
  }
  EXPECT_EQ(x(), 39);
}

TEST_F(Playback, AStopEndsItWithEverythingAnswered) {
  std::stop_source stop;
  PlaybackRequest endless = request(0, 1000);
  endless.stop = stop.get_token();
  const auto report = play(
      client_, endless, [](std::uint64_t k, bool) { return move(k); },
      [&](std::uint64_t frame) {
        if (frame >= 5) stop.request_stop();
      });
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->stream.last_answered, report->frames_sent);
}

TEST_F(Playback, WhatIsRejectedIsToldAndTheNextFrameSaysAll) {
  bool afresh_seen = false;
  const auto report = play(
      client_, request(4, 20),
      [&](std::uint64_t k, bool afresh) {
        afresh_seen = afresh_seen || afresh;
        if (k > 0) return move(k);
        return std::vector<Update>{DeleteNode{99, false}};
      },
      [](std::uint64_t) {});
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_TRUE(report->first_reject);
  EXPECT_EQ(report->first_reject->code, Code::kNotFound);
  EXPECT_EQ(report->stream.rejected, 1U);
  EXPECT_TRUE(afresh_seen);
}

}  // namespace
}  // namespace sightline::client::cli::playback

// The updates of frames, and the choice of frames to send.
#include "client/cli/playback/playback.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stop_token>
#include <utility>
#include <variant>
#include <vector>

#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"
#include "tests/client/support/relay.h"

namespace sightline::client::cli::playback {
namespace {

Transform moved_by(double x) {
  Transform out = kIdentity;
  out[3] = x;
  return out;
}

TEST(FrameUpdates, HoldOnlyChanges) {
  FrameUpdates frames({10, 11, 12, 13});
  importer::Pose pose;
  pose.placed = {{0, moved_by(1)}, {1, moved_by(2)}};
  pose.shaped = {{{2, 3}, {{0, 0, 1}}}};
  std::vector<Update> updates = frames.make(pose);
  ASSERT_EQ(updates.size(), 2U);
  EXPECT_EQ(std::get<SetTransforms>(updates[0]).nodes, (std::vector<NodeRef>{10, 11}));
  EXPECT_EQ(std::get<PatchVertices>(updates[1]).nodes, (std::vector<NodeRef>{12, 13}));
  EXPECT_TRUE(frames.make(pose).empty());

  pose.placed[1].parent_from_local = moved_by(3);
  updates = frames.make(pose);
  ASSERT_EQ(updates.size(), 1U);
  EXPECT_EQ(std::get<SetTransforms>(updates[0]).nodes, std::vector<NodeRef>{11});

  pose.shaped[0].vertices[0][2] = 2;
  updates = frames.make(pose);
  ASSERT_EQ(updates.size(), 1U);
  EXPECT_EQ(std::get<PatchVertices>(updates[0]).positions, (std::vector<Vertex>{{0, 0, 2}}));

  frames.forget();
  EXPECT_EQ(frames.make(pose).size(), 2U);
}

TEST(FrameUpdates, SkipNodesWithoutAnId) {
  FrameUpdates frames({0, 11, 0, 13});
  importer::Pose pose;
  pose.placed = {{0, moved_by(1)}, {1, moved_by(2)}};
  pose.shaped = {{{2, 3}, {{0, 0, 1}}}, {{0}, {{0, 0, 1}}}};
  const std::vector<Update> updates = frames.make(pose);
  ASSERT_EQ(updates.size(), 2U);
  EXPECT_EQ(std::get<SetTransforms>(updates[0]).nodes, std::vector<NodeRef>{11});
  EXPECT_EQ(std::get<PatchVertices>(updates[1]).nodes, std::vector<NodeRef>{13});
}

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

TEST_F(Playback, EveryFrameIsCountedAndTheLastIsSent) {
  // At this rate some frames are late; how many depends on the machine.
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

TEST_F(Playback, EmptyFramesAreNotSent) {
  const auto report = play(
      client_, request(3, 1000), [](std::uint64_t, bool) { return std::vector<Update>(); },
      [](std::uint64_t) {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->frames_sent, 0U);
  EXPECT_EQ(report->frames_unchanged + report->frames_late, 3U);
  EXPECT_EQ(client_.get_scene(kScene)->revision, 1U);
}

TEST_F(Playback, FramesAreDroppedWhileTheWindowIsFullAndTheNextOneIsComplete) {
  constexpr std::size_t kWindow = 16;
  tests::Relay relay(server_->port());
  const auto through = Client::connect(relay.endpoint());
  ASSERT_TRUE(through);
  struct Shown {
    std::uint64_t frame;
    bool afresh;
  };
  std::vector<Shown> shown;
  std::stop_source stop;
  PlaybackRequest endless = request(0, 100);
  endless.stop = stop.get_token();
  const auto report = play(
      *through, endless,
      [&](std::uint64_t frame, bool afresh) {
        if (shown.empty()) relay.hold(true);
        // Answers resume after a frame has been dropped.
        if (afresh) relay.hold(false);
        // The frame before this one was complete, and was sent.
        if (!afresh && !shown.empty() && shown.back().afresh) stop.request_stop();
        shown.push_back({frame, afresh});
        return move(frame);
      },
      [](std::uint64_t) {});
  ASSERT_TRUE(report) << report.error().message;
  const auto afresh = [](const Shown& frame) { return frame.afresh; };
  const auto first = std::find_if(shown.begin(), shown.end(), afresh);
  EXPECT_EQ(first - shown.begin(), kWindow + 1)
      << "one frame more than the window takes is dropped";
  EXPECT_EQ(report->frames_sent + report->frames_dropped, shown.size());
  const bool last_sent = x() == static_cast<double>(shown.back().frame);
  EXPECT_EQ(std::count_if(shown.begin(), shown.end(), afresh) + (last_sent ? 0 : 1),
            report->frames_dropped);
}

TEST_F(Playback, AStopEndsItAfterAllAnswers) {
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

TEST_F(Playback, ARejectedFrameIsReportedAndTheNextOneIsComplete) {
  bool rejected = false;
  int afresh_seen = 0;
  std::stop_source stop;
  PlaybackRequest endless = request(0, 100);
  endless.stop = stop.get_token();
  const auto report = play(
      client_, endless,
      [&](std::uint64_t frame, bool afresh) {
        if (!std::exchange(rejected, true)) return std::vector<Update>{DeleteNode{99, false}};
        if (afresh) {
          ++afresh_seen;
          stop.request_stop();
        }
        return move(frame);
      },
      [](std::uint64_t) {});
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_TRUE(report->first_reject);
  EXPECT_EQ(report->first_reject->code, Code::kNotFound);
  EXPECT_EQ(report->stream.rejected, 1U);
  EXPECT_EQ(afresh_seen, 1);
}

}  // namespace
}  // namespace sightline::client::cli::playback

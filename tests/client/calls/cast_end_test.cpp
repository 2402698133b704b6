// Streams of rays that end before their rays do.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <stop_token>

#include "client/client.h"
#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"
#include "tests/client/support/relay.h"

namespace sightline::client::calls {
namespace {

using tests::DownwardRays;
using tests::kScene;

class CastEnd : public tests::LiveClient {
 protected:
  CastEnd() { EXPECT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(1), {})); }
};

TEST_F(CastEnd, AStopCancelsTheCast) {
  std::stop_source stop;
  stop.request_stop();
  const DownwardRays rays(3 * kRaysPerMessage, 1);
  const CastOptions options{.stop = stop.get_token()};
  EXPECT_EQ(client_.cast_stream(kScene, rays.columns(), {}, options).error().code,
            Code::kCancelled);
  EXPECT_EQ(client_.cast(kScene, DownwardRays(1, 1).columns(), {}, options).error().code,
            Code::kCancelled);
}

// Endless rays down onto the first copy.
RaySource<double> endless() {
  return [](const RayColumns<double>& buffer) -> Result<std::size_t> {
    const DownwardRays rays(buffer.size(), 1);
    std::copy(rays.origins.begin(), rays.origins.end(), buffer.origins.begin());
    std::copy(rays.directions.begin(), rays.directions.end(), buffer.directions.begin());
    return buffer.size();
  };
}

TEST_F(CastEnd, ASinkThatFailsEndsTheCast) {
  int calls = 0;
  const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& hits) -> Status {
    EXPECT_EQ(first, static_cast<std::uint64_t>(calls) * kRaysPerMessage);
    EXPECT_EQ(count, kRaysPerMessage);
    EXPECT_EQ(hits.t.size(), count);
    if (++calls == 6) return Error{Code::kDataLoss, "disk full", {}};
    return {};
  };
  const auto report = client_.cast_stream(kScene, endless(), {}, {.t = true}, sink);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message, "disk full");
  EXPECT_EQ(calls, 6);
}

TEST_F(CastEnd, AServerThatFreezesEndsTheCast) {
  tests::Relay relay(server_->port());
  const Client client = *Client::connect(relay.endpoint());
  const HitSink sink = [&](std::uint64_t, std::size_t, const HitView&) {
    relay.hold(true);
    return Status();
  };
  const auto report = client.cast_stream(kScene, endless(), {}, {.t = true}, sink);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, Code::kUnavailable);
}

TEST_F(CastEnd, ASourceThatFailsEndsTheCast) {
  int calls = 0;
  const RaySource<double> all = endless();
  const RaySource<double> source = [&](const RayColumns<double>& buffer) -> Result<std::size_t> {
    if (++calls == 6) return Error{Code::kInvalidArgument, "line 7", {}};
    return all(buffer);
  };
  const HitSink sink = [](std::uint64_t, std::size_t, const HitView&) { return Status(); };
  const auto report = client_.cast_stream(kScene, source, {}, {.t = true}, sink);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message, "line 7");
}

TEST_F(CastEnd, AStreamEndsWithItsServer) {
  const HitSink sink = [&](std::uint64_t, std::size_t, const HitView&) {
    stop_server();
    return Status();
  };
  const auto report = client_.cast_stream(kScene, endless(), {}, {.t = true}, sink);
  ASSERT_FALSE(report);
}

}  // namespace
}  // namespace sightline::client::calls

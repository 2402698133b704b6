// Whether a client uses segments, and what it says why.
#include "client/calls/segment_pool.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"
#include "tests/client/support/silent_port.h"

namespace sightline::client::calls {
namespace {

using tests::DownwardRays;
using tests::kScene;

std::string refusal(const std::string& endpoint, const ClientOptions& options = {}) {
  return SegmentPool::refusal_of(*Endpoint::parse(endpoint), options);
}

TEST(SegmentPool, IsForOneServerOnThisMachine) {
  EXPECT_EQ(refusal("unix:/run/socket"), "");
  EXPECT_EQ(refusal("127.0.0.1:50151"), "");
  EXPECT_EQ(refusal("localhost:50151"), "");
  EXPECT_NE(refusal("unix:/run/socket", {.use_segments = false}), "");
  EXPECT_NE(refusal("10.1.2.3:50151"), "");
  EXPECT_NE(refusal("server:50151"), "");
  EXPECT_NE(refusal("127.0.0.1:50151,127.0.0.1:50152"), "");
}

TEST(SegmentPool, AClientThatMayNotHasOrdinaryMemory) {
  const auto client = Client::connect("unix:/nowhere/at/all", {.use_segments = false});
  ASSERT_TRUE(client);
  EXPECT_EQ(client->transport().transport, Transport::kMessages);
  const auto memory = client->share_memory(1 << 20);
  ASSERT_TRUE(memory) << memory.error().message;
  EXPECT_FALSE(memory->is_shared());
  EXPECT_EQ(memory->why_not_shared(), client->transport().reason);
  EXPECT_FALSE(client->share_memory(0));
}

class WithoutSegments : public tests::LiveClient {
 protected:
  WithoutSegments() { EXPECT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(1), {})); }

  void cast() {
    const DownwardRays rays(5000, 1);
    std::vector<double> t(5000);
    const auto report = client_.cast_stream(kScene, rays.columns(), {.t = t});
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(t, std::vector<double>(5000, 4.0));
    ASSERT_TRUE(client_.cast(kScene, rays.columns(), {.t = t}));
  }
};

// Servers offer segments over Unix sockets alone, unless they are told otherwise.
TEST_F(WithoutSegments, CastsGoByMessagesAndTheClientSaysWhy) {
  EXPECT_EQ(client_.transport().transport, Transport::kMessages);
  EXPECT_EQ(client_.transport().reason, "no cast has needed shared memory");
  cast();
  EXPECT_EQ(client_.transport().transport, Transport::kMessages);
  EXPECT_EQ(client_.transport().reason, "the server offers no segments to this client");
}

TEST_F(WithoutSegments, MemoryIsOrdinaryAndSaysWhy) {
  const auto memory = client_.share_memory(5000 * 56);
  ASSERT_TRUE(memory) << memory.error().message;
  EXPECT_FALSE(memory->is_shared());
  EXPECT_EQ(memory->why_not_shared(), "the server offers no segments to this client");
  auto origins = memory->array<double>(15000), directions = memory->array<double>(15000);
  auto t = memory->array<double>(5000);
  ASSERT_TRUE(origins && directions && t);
  const DownwardRays rays(5000, 1);
  std::copy(rays.origins.begin(), rays.origins.end(), origins->begin());
  std::copy(rays.directions.begin(), rays.directions.end(), directions->begin());
  const RayColumns<const double> columns{*origins, *directions};
  ASSERT_TRUE(client_.cast(kScene, columns, {.t = *t}));
  EXPECT_EQ(std::vector<double>(t->begin(), t->end()), std::vector<double>(5000, 4.0));
}

TEST_F(WithoutSegments, AServerThatIsGoneIsAnError) {
  stop_server();
  const DownwardRays rays(5000, 1);
  std::vector<double> t(5000);
  EXPECT_EQ(client_.cast(kScene, rays.columns(), {.t = t}).error().code, Code::kUnavailable);
  EXPECT_EQ(client_.transport().transport, Transport::kMessages);
}

}  // namespace
}  // namespace sightline::client::calls

// What live pages that do not read, or whose calls do not take, can make a server hold; and whose
// share their calls use up.
#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/admin/http_server.h"
#include "server/admin/tunnel.h"
#include "server/admin/tunnel_call.h"
#include "server/exec/made_for.h"
#include "server/net/listening_sockets.h"
#include "sightline/page/v1/tunnel.pb.h"
#include "sightline/v1/query.pb.h"
#include "sightline/v1/scene.pb.h"
#include "sightline/v1/server.pb.h"
#include "tests/server/support/live_server.h"
#include "tests/server/support/page.h"
#include "tests/support/scenes.h"
#include "tests/support/sleep_shortly.h"

namespace sightline::server::admin {
namespace {

using page::v1::TunnelRequest;
using tests::kScene;
using tests::Page;

/// Queues of the tunnel both ways, of gRPC, and of the kernel, with much to spare.
constexpr std::size_t kMost = std::size_t{64} << 20;

class TunnelBounds : public tests::LiveServer {
 protected:
  /// Opens a tunnel to the server. Returns its port.
  int serve(std::chrono::milliseconds limit) {
    auto listening = net::listen_on(*net::ListenAddress::parse("127.0.0.1:0"));
    tunnel_ = std::make_unique<Tunnel>(channel_, Tunnel::Access{}, limit);
    http_ = std::make_unique<HttpServer>(
        std::move(listening->sockets), [](auto) { return HttpReply(); }, tunnel_.get());
    return listening->port;
  }

  std::unique_ptr<Tunnel> tunnel_;
  std::unique_ptr<HttpServer> http_;
};

constexpr std::chrono::milliseconds kShort{100};

TEST_F(TunnelBounds, DoesNotReadWhatACallDoesNotTake) {
  api_.make_scene(kScene, tests::cube());
  v1::WatchSceneRequest watch;
  watch.set_scene(kScene);
  Page page(serve(kShort));
  ASSERT_TRUE(page.open());
  TunnelRequest request;
  request.set_call(1);
  request.set_method("/sightline.v1.SceneService/WatchScene");
  request.set_message(watch.SerializeAsString());
  page.send(request);
  ASSERT_TRUE(page.receive());
  request.clear_method();
  request.set_message(std::string(Tunnel::kMaxMessage / 2, 'x'));
  EXPECT_LT(page.flood(request, kMost), kMost);
}

TEST_F(TunnelBounds, DoesNotReadAPageThatDoesNotRead) {
  Page page(serve(kShort));
  ASSERT_TRUE(page.open());
  TunnelRequest request;
  request.set_call(1);
  request.set_method("/elsewhere" + std::string(100, 'x'));  // each is answered at once
  EXPECT_LT(page.flood(request, kMost), kMost);
}

TEST_F(TunnelBounds, ReadsOnWhenTheCallsHaveTaken) {
  api_.make_scene(kScene, tests::planar_sheet(1));
  Page page(serve(exec::kReplyTimeout));
  ASSERT_TRUE(page.open());
  v1::StreamCastRaysRequest cast;
  *cast.mutable_request() = tests::cast_request(kScene, tests::rays_downward(10000));
  cast.mutable_request()->set_kind(v1::QUERY_KIND_ANY);  // with small answers
  cast.mutable_request()->clear_fields();
  TunnelRequest request;
  request.set_call(1);
  request.set_method("/sightline.v1.RayQueryService/StreamCastRays");
  constexpr std::size_t kAnswers = 40;  // more than may wait, together
  for (std::size_t i = 1; i <= kAnswers; ++i) {
    cast.set_chunk(i);
    request.set_message(cast.SerializeAsString());
    request.set_last(i == kAnswers);
    ASSERT_LT(request.ByteSizeLong(), Tunnel::kMaxMessage);
    page.send(request);
    request.clear_method();
  }
  std::size_t answers = 0;
  for (auto answer = page.receive(); answer && !answer->has_end(); answer = page.receive())
    ++answers;
  EXPECT_EQ(answers, kAnswers);
}

/// Its answer may be on its way already, and is then read by no one.
TEST_F(TunnelBounds, EveryCancelledCallEnds) {
  Tunnel tunnel(channel_, {});
  const std::string request = v1::GetServerInfoRequest().SerializeAsString();
  std::vector<std::weak_ptr<TunnelCall>> calls;
  constexpr int kCalls = 2000;
  for (int i = 0; i < kCalls; ++i) {
    const auto call = TunnelCall::open(tunnel,
                                       {.method = "/sightline.v1.ServerService/GetServerInfo",
                                        .authorization = {},
                                        .peer = "ipv4:127.0.0.1:1"},
                                       {.message = [](const std::string&) {},
                                        .taken = [](std::size_t) {},
                                        .ended = [](const grpc::Status&) {}});
    ASSERT_TRUE(call);
    (*call)->send(request, true);
    std::this_thread::sleep_for(std::chrono::microseconds(i % 500));  // cancels at any moment
    (*call)->cancel();
    calls.push_back(*call);
  }
  for (const std::weak_ptr<TunnelCall>& call : calls) {
    while (!call.expired()) tests::sleep_shortly();
  }
  tunnel.stop();
  tunnel.end_calls();
}

server::ServerConfig with_a_quota() {
  server::ServerConfig config = tests::test_config();
  config.admin = "127.0.0.1:0";
  config.quotas.others = {1, 0, 0, 0};  // rays a second; a first batch may be larger
  return config;
}

class TunnelShares : public tests::LiveServer {
 protected:
  TunnelShares() : LiveServer(with_a_quota()) {
    api_.make_scene(kScene, tests::cube());
    cast_ = tests::cast_request(kScene, tests::rays_downward(10000));
  }

  int cast_from(const std::string& address) const {
    Page page(server_->admin_port(), address);
    EXPECT_TRUE(page.open());
    page.call(1, "RayQueryService/CastRays", cast_);
    return page.end();
  }

  v1::CastRaysRequest cast_;
};

TEST_F(TunnelShares, OnePageAndOneClientOfAnAddressHaveOneQuota) {
  v1::CastRaysResponse reply;
  ASSERT_TRUE(api_.cast(cast_, &reply).ok());
  EXPECT_EQ(cast_from("127.0.0.1"), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(cast_from("127.0.0.2"), grpc::StatusCode::OK);
  EXPECT_EQ(cast_from("127.0.0.2"), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST_F(TunnelShares, AClientCannotSayWhoItIs) {
  v1::CastRaysResponse reply;
  ASSERT_TRUE(api_.cast(cast_, &reply).ok());
  grpc::ClientContext context;
  context.AddMetadata(exec::kMadeFor, "ipv4:127.0.0.9:1");
  EXPECT_EQ(api_.rays->CastRays(&context, cast_, &reply).error_code(),
            grpc::StatusCode::RESOURCE_EXHAUSTED);
}

}  // namespace
}  // namespace sightline::server::admin

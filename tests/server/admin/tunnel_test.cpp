// Calls of live pages through WebSockets, against a whole server.
#include "server/admin/tunnel.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <deque>
#include <filesystem>
#include <fstream>
#include <string>

#include "server/server.h"
#include "sightline/page/v1/tunnel.pb.h"
#include "sightline/v1/scene.pb.h"
#include "sightline/v1/server.pb.h"
#include "tests/server/support/page.h"
#include "tests/server/support/token_file.h"

namespace sightline::server::admin {
namespace {

using page::v1::TunnelRequest;
using tests::Page;

std::unique_ptr<Server> serve(const std::filesystem::path& tokens = {}) {
  ServerConfig config;
  config.listen = "127.0.0.1:0";
  config.admin = "127.0.0.1:0";
  config.tokens = tokens;
  auto server = Server::start(config);
  EXPECT_TRUE(server) << server.error().message;
  return *std::move(server);
}

TEST(TunnelTest, TransfersACall) {
  const auto server = serve();
  Page page(server->admin_port());
  ASSERT_TRUE(page.open());
  page.call(7, "ServerService/GetServerInfo", v1::GetServerInfoRequest());
  const auto answer = page.receive();
  ASSERT_TRUE(answer && answer->has_message());
  EXPECT_EQ(answer->call(), 7u);
  v1::GetServerInfoResponse info;
  ASSERT_TRUE(info.ParseFromString(answer->message()));
  EXPECT_GT(info.threads(), 0u);
  EXPECT_EQ(page.end(), grpc::StatusCode::OK);
}

TEST(TunnelTest, TransfersErrorsWithTheirDetails) {
  const auto server = serve();
  Page page(server->admin_port());
  ASSERT_TRUE(page.open());
  v1::GetSceneRequest request;
  request.set_name("projects/default/scenes/none");
  page.call(1, "SceneService/GetScene", request);
  const auto answer = page.receive();
  ASSERT_TRUE(answer && answer->has_end());
  EXPECT_EQ(answer->end().code(), static_cast<std::uint32_t>(grpc::StatusCode::NOT_FOUND));
  EXPECT_FALSE(answer->end().details().empty());
}

TEST(TunnelTest, EndsAStreamThatIsCancelled) {
  const auto server = serve();
  Page page(server->admin_port());
  ASSERT_TRUE(page.open());
  v1::CreateSceneRequest create;
  create.mutable_scene()->set_name("projects/default/scenes/one");
  page.call(1, "SceneService/CreateScene", create);
  ASSERT_EQ(page.end(), grpc::StatusCode::OK);
  v1::WatchSceneRequest watch;
  watch.set_scene("projects/default/scenes/one");
  page.call(2, "SceneService/WatchScene", watch);
  const auto progress = page.receive();
  ASSERT_TRUE(progress && progress->has_message());
  TunnelRequest cancel;
  cancel.set_call(2);
  cancel.set_cancel(true);
  page.send(cancel);
  EXPECT_EQ(page.end(), grpc::StatusCode::CANCELLED);
}

TEST(TunnelTest, RefusesTooManyCallsAndOtherServices) {
  const auto server = serve();
  Page page(server->admin_port());
  ASSERT_TRUE(page.open());
  TunnelRequest open;
  open.set_method("/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo");
  open.set_call(1);
  page.send(open);
  EXPECT_EQ(page.end(), grpc::StatusCode::UNIMPLEMENTED);
  for (std::uint32_t call = 1; call <= Tunnel::kMaxCalls + 1; ++call) page.open_stream(call);
  const auto refused = page.receive();
  ASSERT_TRUE(refused && refused->has_end());
  EXPECT_EQ(refused->call(), Tunnel::kMaxCalls + 1);
  EXPECT_EQ(refused->end().code(),
            static_cast<std::uint32_t>(grpc::StatusCode::RESOURCE_EXHAUSTED));
}

TEST(TunnelTest, ClosesASocketThatBreaksTheRules) {
  const auto server = serve();
  Page twice(server->admin_port());
  ASSERT_TRUE(twice.open());
  twice.open_stream(1);
  twice.open_stream(1);
  EXPECT_FALSE(twice.receive());
}

TEST(TunnelTest, AdmitsPagesOfThisServerAlone) {
  const auto server = serve();
  const std::string here = "127.0.0.1:" + std::to_string(server->admin_port());
  EXPECT_TRUE(Page(server->admin_port()).open("http://" + here, here));
  EXPECT_FALSE(Page(server->admin_port()).open("http://elsewhere.example", here));
  EXPECT_FALSE(Page(server->admin_port()).open("http://a.example", "a.example"))
      << "anybody may point a name here";
  EXPECT_TRUE(Page(server->admin_port()).open({}, "localhost:1"));
  EXPECT_TRUE(Page(server->admin_port()).open({}, "[::1]:1"));
}

TEST(TunnelTest, AdmitsFewPagesAtATime) {
  const auto server = serve();
  std::deque<Page> pages;
  for (std::size_t i = 0; i < Tunnel::kMaxSockets; ++i)
    EXPECT_TRUE(pages.emplace_back(server->admin_port()).open());
  EXPECT_FALSE(Page(server->admin_port()).open());
}

TEST(TunnelTest, SharesItsSocketsByAddress) {
  const auto server = serve();
  std::deque<Page> pages;
  for (std::size_t i = 0; i < Tunnel::kMaxSockets; ++i)
    ASSERT_TRUE(pages.emplace_back(server->admin_port()).open());
  Page other(server->admin_port(), "127.0.0.2");
  EXPECT_TRUE(other.open());
  EXPECT_FALSE(pages.back().receive()) << "the newest of the address that has all gives way";
  other.call(1, "ServerService/GetServerInfo", v1::GetServerInfoRequest());
  EXPECT_EQ(other.end(), grpc::StatusCode::OK);
  EXPECT_FALSE(Page(server->admin_port()).open()) << "it has most";
}

TEST(TunnelTest, RefusesWhatCannotBeAHeader) {
  const auto server = serve();
  Page page(server->admin_port());
  ASSERT_TRUE(page.open());
  std::uint32_t number = 0;
  for (const std::string bad : {"Bearer x\n", "Bearer \xc3\xa9", "Bearer \x7f", "\t"}) {
    page.call(++number, "ServerService/GetServerInfo", v1::GetServerInfoRequest(), bad);
    EXPECT_EQ(page.end(), grpc::StatusCode::UNAUTHENTICATED) << bad;
  }
  const std::string zero("Bearer x\0y", 10);
  page.call(++number, "ServerService/GetServerInfo", v1::GetServerInfoRequest(), zero);
  EXPECT_EQ(page.end(), grpc::StatusCode::UNAUTHENTICATED);
  for (const std::string bad : {"\n", "\xc3\xa9", "A B/C", ""}) {
    page.call(++number, "ServerService/" + bad, v1::GetServerInfoRequest());
    EXPECT_EQ(page.end(), grpc::StatusCode::UNIMPLEMENTED) << bad;
  }
  page.call(++number, std::string(1000, 'a'), v1::GetServerInfoRequest());
  EXPECT_EQ(page.end(), grpc::StatusCode::UNIMPLEMENTED);
  page.call(++number, "ServerService/GetServerInfo", v1::GetServerInfoRequest());
  EXPECT_EQ(page.end(), grpc::StatusCode::OK);
}

TEST(TunnelTest, CallsNeedTheSameTokens) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) /
                                     ("page_tokens_" + std::to_string(getpid()) + ".toml");
  std::ofstream(file) << tests::token_row("viewer", "a-token", "read", R"("")");
  const auto server = serve(file);
  Page page(server->admin_port());
  ASSERT_TRUE(page.open({}, "named.example"));
  page.call(1, "ServerService/GetServerInfo", v1::GetServerInfoRequest());
  EXPECT_EQ(page.end(), grpc::StatusCode::UNAUTHENTICATED);
  page.call(2, "ServerService/GetServerInfo", v1::GetServerInfoRequest(), "Bearer a-token");
  EXPECT_EQ(page.end(), grpc::StatusCode::OK);
  page.call(3, "ServerService/ReadLog", v1::ReadLogRequest(), "Bearer a-token");
  EXPECT_EQ(page.end(), grpc::StatusCode::PERMISSION_DENIED);
  std::filesystem::remove(file);
}

TEST(TunnelTest, AServerThatEndsEndsTheCalls) {
  auto server = serve();
  Page page(server->admin_port());
  ASSERT_TRUE(page.open());
  page.open_stream(1);
  server.reset();
  while (page.receive()) continue;
}

}  // namespace
}  // namespace sightline::server::admin

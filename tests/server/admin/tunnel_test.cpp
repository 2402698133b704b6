// Calls of live pages through WebSockets, against a whole server.
#include "server/admin/tunnel.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <deque>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "server/server.h"
#include "sightline/page/v1/tunnel.pb.h"
#include "sightline/v1/scene.pb.h"
#include "sightline/v1/server.pb.h"
#include "tests/server/support/token_file.h"

namespace sightline::server::admin {
namespace {

namespace websocket = boost::beast::websocket;
using boost::asio::ip::tcp;
using page::v1::TunnelRequest;
using page::v1::TunnelResponse;

/// A page's socket.
class Page {
 public:
  explicit Page(int port) {
    socket_.next_layer().connect(tcp::endpoint(boost::asio::ip::make_address("127.0.0.1"),
                                               static_cast<std::uint16_t>(port)));
  }

  /// Returns whether the server opened the socket.
  bool open(const std::string& origin = {}, const std::string& host = "127.0.0.1") {
    socket_.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
      if (!origin.empty()) request.set(boost::beast::http::field::origin, origin);
    }));
    boost::system::error_code error;
    socket_.handshake(host, "/", error);
    socket_.binary(true);
    EXPECT_TRUE(!error || error == websocket::error::upgrade_declined) << error.message();
    return !error;
  }

  void send(const TunnelRequest& request) {
    socket_.write(boost::asio::buffer(request.SerializeAsString()));
  }
  void call(std::uint32_t number, const std::string& method,
            const google::protobuf::Message& message, const std::string& authorization = {}) {
    TunnelRequest request;
    request.set_call(number);
    request.set_method("/sightline.v1." + method);
    request.set_authorization(authorization);
    request.set_message(message.SerializeAsString());
    request.set_last(true);
    send(request);
  }

  /// A stream of rays that stays open.
  void open_stream(std::uint32_t number) {
    TunnelRequest request;
    request.set_call(number);
    request.set_method("/sightline.v1.RayQueryService/StreamCastRays");
    send(request);
  }

  /// Nothing: the socket was closed.
  std::optional<TunnelResponse> receive() {
    boost::beast::flat_buffer buffer;
    boost::system::error_code error;
    socket_.read(buffer, error);
    TunnelResponse response;
    if (error || !response.ParseFromArray(buffer.data().data(), static_cast<int>(buffer.size())))
      return {};
    return response;
  }
  /// The code with which the next call ends, messages before it left out.
  int end() {
    for (;;) {
      const auto response = receive();
      if (!response) return -1;
      if (response->has_end()) return static_cast<int>(response->end().code());
    }
  }

 private:
  boost::asio::io_context context_;
  websocket::stream<tcp::socket> socket_{context_};
};

std::unique_ptr<Server> serve(const std::filesystem::path& tokens = {}) {
  ServerConfig config;
  config.listen = "127.0.0.1:0";
  config.admin = "127.0.0.1:0";
  config.tokens = tokens;
  auto server = Server::start(config);
  EXPECT_TRUE(server) << server.error().message;
  return *std::move(server);
}

TEST(TunnelTest, CarriesACall) {
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

TEST(TunnelTest, CarriesErrorsWithTheirDetails) {
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

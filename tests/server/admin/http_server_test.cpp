// A small HTTP/1.1 server for probes and metrics.
#include "server/admin/http_server.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <cstddef>
#include <filesystem>
#include <latch>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "server/net/listening_sockets.h"
#include "tests/server/support/tcp.h"

namespace sightline::server::admin {
namespace {

using net::Descriptor;
using tests::connect_tcp;
using tests::receive_bytes;
using tests::send_bytes;

constexpr std::size_t kLarge = std::size_t{4} << 20;

class HttpServerTest : public testing::Test {
 protected:
  HttpServerTest() {
    auto listening = net::listen_on(*net::ListenAddress::parse("127.0.0.1:0"));
    port_ = listening->port;
    server_ = std::make_unique<HttpServer>(std::move(listening->sockets), [this](auto path) {
      if (path == "/wait") done_waiting_.wait();
      if (path == "/throw") throw std::runtime_error("thrown");
      if (path == "/large") return HttpReply{.body = std::string(kLarge, 'x')};
      if (path == "/no") return HttpReply{.code = 503, .body = "no\n"};
      return HttpReply{.body = "path " + std::string(path) + "\n"};
    });
  }

  /// All that the server sends until it closes the connection.
  static std::string rest(const Descriptor& connection) {
    std::string all;
    for (std::string some; !(some = receive_bytes(connection)).empty();) all += some;
    return all;
  }

  std::string ask(const std::string& request) const {
    const Descriptor connection = connect_tcp(port_);
    send_bytes(connection, request);
    return rest(connection);
  }

  int port_ = 0;
  std::latch done_waiting_{1};
  std::unique_ptr<HttpServer> server_;
};

TEST_F(HttpServerTest, AnswersGetAndHead) {
  const std::string reply = ask("GET /a?b=c HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_TRUE(reply.starts_with("HTTP/1.1 200 OK\r\n")) << reply;
  EXPECT_NE(reply.find("\r\nContent-Length: 8\r\n"), std::string::npos) << reply;
  EXPECT_TRUE(reply.ends_with("\r\n\r\npath /a\n")) << reply;
  const std::string head = ask("HEAD /a HTTP/1.0\r\n\r\n");
  EXPECT_NE(head.find("\r\nContent-Length: 8\r\n"), std::string::npos) << head;
  EXPECT_TRUE(head.ends_with("\r\n\r\n")) << head;
  EXPECT_TRUE(ask("GET /no HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 503 Service Unavailable\r\n"));
}

TEST_F(HttpServerTest, TellsThatItIsAliveWhileAPageWaits) {
  std::vector<Descriptor> waiting;
  for (std::size_t i = 0; i < HttpServer::kMaxConnections / 2; ++i) {
    waiting.push_back(connect_tcp(port_));
    send_bytes(waiting.back(), "GET /wait HTTP/1.1\r\n\r\n");
  }
  EXPECT_TRUE(ask("GET /livez HTTP/1.1\r\n\r\n").ends_with("alive\n"));
  done_waiting_.count_down();
  for (const Descriptor& one : waiting) EXPECT_TRUE(rest(one).ends_with("path /wait\n"));
}

TEST_F(HttpServerTest, RefusesWhatItDoesNotKnow) {
  EXPECT_TRUE(ask("POST /a HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 405 "));
  for (const std::string bad : {"\r\n\r\n", "GET\r\n\r\n", "GET /a\r\n\r\n",
                                "GET /a FTP/1.1\r\n\r\n", "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"})
    EXPECT_TRUE(ask(bad).starts_with("HTTP/1.1 400 ")) << bad;
  EXPECT_TRUE(ask("GET /throw HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 500 "));
}

TEST_F(HttpServerTest, EndsARequestThatIsTooLarge) {
  const Descriptor connection = connect_tcp(port_);
  send_bytes(connection, "GET /a HTTP/1.1\r\nX: " + std::string(HttpServer::kMaxRequest, 'a'));
  EXPECT_TRUE(rest(connection).starts_with("HTTP/1.1 431 "));
}

TEST_F(HttpServerTest, AnswersARequestThatComesInParts) {
  const Descriptor connection = connect_tcp(port_);
  for (const char byte : std::string("GET /a HTTP/1.1\r\n\r\n"))
    send_bytes(connection, std::string(1, byte));
  EXPECT_TRUE(rest(connection).ends_with("path /a\n"));
}

TEST_F(HttpServerTest, SendsALargeReplyWhole) {
  const std::string reply = ask("GET /large HTTP/1.1\r\n\r\n");
  EXPECT_TRUE(reply.ends_with(std::string(kLarge, 'x')));
}

TEST_F(HttpServerTest, PeersThatSendOrReadNothingDoNotHoldUpOthers) {
  std::vector<Descriptor> silent, greedy;
  for (std::size_t i = 0; i < HttpServer::kMaxConnections; ++i) {
    silent.push_back(connect_tcp(port_));
    greedy.push_back(connect_tcp(port_));
    send_bytes(greedy.back(), "GET /large HTTP/1.1\r\n\r\n");
  }
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(ask("GET /a HTTP/1.1\r\n\r\n").ends_with("path /a\n"));
  // They have given way, or their time is over in the end.
  for (const Descriptor& connection : silent) EXPECT_EQ(rest(connection), "");
}

TEST_F(HttpServerTest, AProbeGivesWayToNoFloodOfPages) {
  const Descriptor blocking = connect_tcp(port_);
  send_bytes(blocking, "GET /wait HTTP/1.1\r\n\r\n");
  const Descriptor probe = connect_tcp(port_);
  send_bytes(probe, "GET /readyz HTTP/1.1\r\n\r\n");
  EXPECT_TRUE(ask("GET /livez HTTP/1.1\r\n\r\n").ends_with("alive\n")) << "the probe was read";
  std::vector<Descriptor> flood;
  for (std::size_t i = 0; i < 4 * HttpServer::kMaxConnections; ++i) {
    flood.push_back(connect_tcp(port_));
    send_bytes(flood.back(), "GET /metrics HTTP/1.1\r\n\r\n");
    if (i % HttpServer::kMaxConnections == 0) {
      EXPECT_TRUE(ask("GET /livez HTTP/1.1\r\n\r\n").ends_with("alive\n")) << i;
    }
  }
  done_waiting_.count_down();
  EXPECT_TRUE(rest(probe).ends_with("path /readyz\n"));
}

TEST_F(HttpServerTest, TheAddressWithMostConnectionsGivesWay) {
  const Descriptor blocking = connect_tcp(port_, "127.0.0.2");
  send_bytes(blocking, "GET /wait HTTP/1.1\r\n\r\n");
  EXPECT_TRUE(ask("GET /livez HTTP/1.1\r\n\r\n").ends_with("alive\n"));
  std::vector<Descriptor> flood;
  for (std::size_t i = 0; i < 2 * HttpServer::kMaxConnections; ++i)
    flood.push_back(connect_tcp(port_));
  EXPECT_TRUE(ask("GET /livez HTTP/1.1\r\n\r\n").ends_with("alive\n"));
  done_waiting_.count_down();
  EXPECT_TRUE(rest(blocking).ends_with("path /wait\n"));
}

/// The server's end of this connection; both are in this process.
int other_end(const Descriptor& connection) {
  sockaddr_in own{}, peer{};
  socklen_t size = sizeof own;
  EXPECT_EQ(getsockname(connection.number(), reinterpret_cast<sockaddr*>(&own), &size), 0);
  for (const auto& file : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int number = std::stoi(file.path().filename());
    size = sizeof peer;
    if (getpeername(number, reinterpret_cast<sockaddr*>(&peer), &size) == 0 &&
        peer.sin_family == AF_INET && peer.sin_port == own.sin_port)
      return number;
  }
  return -1;
}

TEST_F(HttpServerTest, SendsWithoutDelay) {
  const Descriptor connection = connect_tcp(port_);
  EXPECT_TRUE(ask("GET /livez HTTP/1.1\r\n\r\n").ends_with("alive\n")) << "it is accepted";
  int on = 0;
  socklen_t size = sizeof on;
  ASSERT_EQ(getsockopt(other_end(connection), IPPROTO_TCP, TCP_NODELAY, &on, &size), 0);
  EXPECT_EQ(on, 1);
}

TEST_F(HttpServerTest, StopsWithOpenConnections) {
  const Descriptor silent = connect_tcp(port_);
  server_.reset();
  EXPECT_EQ(rest(silent), "");
}

}  // namespace
}  // namespace sightline::server::admin

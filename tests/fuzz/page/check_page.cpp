// Checks that the admin port bears what a page sends.
#include "tests/fuzz/page/check_page.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "server/net/descriptor.h"
#include "server/server.h"
#include "sightline/page/v1/tunnel.pb.h"

namespace sightline::tests {
namespace {

/// A server that takes longer hangs.
constexpr timeval kAnswerLimit{.tv_sec = 60, .tv_usec = 0};

const server::Server& target() {
  static const std::unique_ptr<server::Server> started = [] {
    spdlog::set_level(spdlog::level::off);
    server::ServerConfig config;
    config.listen = "127.0.0.1:0";
    config.admin = "127.0.0.1:0";
    config.threads = 2;
    auto made = server::Server::start(config);
    if (!made) {
      std::fprintf(stderr, "page: %s\n", made.error().message.c_str());
      std::abort();
    }
    return *std::move(made);
  }();
  return *started;
}

/// A WebSocket of which nothing is taken for granted.
class RawPage {
 public:
  RawPage() : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(target().admin_port()));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int on = 1;
    setsockopt(socket_.number(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    setsockopt(socket_.number(), SOL_SOCKET, SO_RCVTIMEO, &kAnswerLimit, sizeof kAnswerLimit);
    // libFuzzer's timer interrupts it; then it goes on by itself.
    while (connect(socket_.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) !=
               0 &&
           (errno == EINTR || errno == EALREADY))
      continue;
    send(
        "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n");
    while (head_.find("\r\n\r\n") == std::string::npos && receive(head_, 0)) continue;
  }

  bool is_open() const { return head_.starts_with("HTTP/1.1 101 "); }

  /// What the socket does not take at once is left out.
  void send(const std::string& bytes) {
    static_cast<void>(TEMP_FAILURE_RETRY(
        ::send(socket_.number(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT)));
  }

  /// `first`: of the frame. It is masked with zeros.
  void send_frame(char first, const std::string& payload) {
    std::string frame(1, first);
    if (payload.size() < 126) {
      frame += static_cast<char>(0x80 | payload.size());
    } else {
      frame += static_cast<char>(0x80 | 126);
      frame += static_cast<char>(payload.size() >> 8);
      frame += static_cast<char>(payload.size());
    }
    send(frame + std::string(4, '\0') + payload);
  }

  /// Appends what has come. False: nothing, as the server has closed the connection or is late.
  bool receive(std::string& to, int flags) {
    std::array<char, 65536> part{};
    const ssize_t got = TEMP_FAILURE_RETRY(recv(socket_.number(), part.data(), part.size(), flags));
    if (got > 0) to.append(part.data(), static_cast<std::size_t>(got));
    is_late_ = got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK);
    return got > 0;
  }

  /// Sends no more, and reads until the server has closed the connection; false if it does not.
  bool end() {
    shutdown(socket_.number(), SHUT_WR);
    std::string rest;
    while (receive(rest, 0)) rest.clear();
    return !is_late_;
  }

 private:
  const server::net::Descriptor socket_;
  std::string head_;
  bool is_late_ = false;
};

void send_step(RawPage& page, const PageStep& step) {
  constexpr char kBinary = '\x82';
  std::string read;
  switch (step.kind) {
    case PageStep::kMessage:
      return page.send_frame(kBinary, step.bytes);
    case PageStep::kFrame:
      if (!step.bytes.empty()) page.send_frame(step.bytes.front(), step.bytes.substr(1));
      return;
    case PageStep::kRaw:
      return page.send(step.bytes);
    default:
      page.receive(read, MSG_DONTWAIT);
  }
}

/// Whether another page gets what it asks for.
bool others_are_answered() {
  RawPage page;
  if (!page.is_open()) return false;
  page::v1::TunnelRequest request;
  request.set_call(1);
  request.set_method("/sightline.v1.ServerService/GetServerInfo");
  request.set_message("");
  request.set_last(true);
  page.send_frame('\x82', request.SerializeAsString());
  std::string answers;
  return page.receive(answers, 0);
}

}  // namespace

std::optional<std::string> check_page(const std::vector<PageStep>& steps) {
  {
    RawPage page;
    if (!page.is_open()) return "the server opens no socket";
    for (const PageStep& step : steps) send_step(page, step);
    if (!page.end()) return "the server does not close the connection";
  }
  if (!others_are_answered()) return "another page is not answered";
  return std::nullopt;
}

}  // namespace sightline::tests

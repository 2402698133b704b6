// What a client may send to the public port, as HTTP/2 or not.
#include "tests/fuzz/port/check_port.h"

#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>
#include <vector>

#include "server/net/descriptor.h"
#include "server/net/frame_guard.h"
#include "server/net/guarded_sockets.h"
#include "tests/server/support/frames.h"

namespace sightline::tests {
namespace {

using server::net::Abuse;
using server::net::Descriptor;
using server::net::FrameGuard;

constexpr std::size_t kMaxStreams = 64;
constexpr int kTimeoutMs = 20'000;  // only a finding takes them

using Bytes = std::span<const std::uint8_t>;

std::optional<Abuse> judge(Bytes bytes, std::size_t piece) {
  FrameGuard guard(kMaxStreams, {});
  while (!bytes.empty()) {
    const Bytes now = bytes.first(std::min(piece, bytes.size()));
    if (const auto verdict = guard.receive(now, {})) return verdict->abuse;
    // What it says of replies must not depend on anything, either.
    guard.send(now, {});
    bytes = bytes.subspan(now.size());
  }
  return std::nullopt;
}

/// Without TLS, so that what is sent reaches gRPC as it is.
class PublicPort {
 public:
  PublicPort() {
    grpc::ServerBuilder builder;
    builder.RegisterCallbackGenericService(&service_);
    builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, int{kMaxStreams});
    builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 10'000);
    acceptor_ = builder.experimental().AddExternalConnectionAcceptor(
        grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
        grpc::InsecureServerCredentials());
    server_ = builder.BuildAndStart();
  }

  /// Returns false if the connection does not end.
  bool take(Bytes bytes) {
    std::array<int, 2> ends{};
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0)
      return false;
    const Descriptor client(ends[0]);
    server::net::guard_socket(ends[1], {.max_streams = kMaxStreams, .tls = false, .ended = ended_});
    grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
    parameters.listener_fd = -1;
    parameters.fd = ends[1];
    acceptor_->HandleNewConnection(&parameters);
    return exchange(client.number(), bytes);
  }

 private:
  static bool exchange(int client, Bytes bytes) {
    std::array<char, 4096> replies{};
    for (;;) {
      pollfd ready{.fd = client, .events = POLLIN, .revents = 0};
      if (!bytes.empty()) ready.events |= POLLOUT;
      const int count = poll(&ready, 1, kTimeoutMs);
      if (count < 0 && errno == EINTR) continue;  // libFuzzer's own timer
      if (count != 1) return false;
      if ((ready.revents & POLLOUT) != 0) {
        const ssize_t size = send(client, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        bytes = size < 0 ? Bytes() : bytes.subspan(static_cast<std::size_t>(size));
        if (bytes.empty()) shutdown(client, SHUT_WR);
      }
      if ((ready.revents & (POLLIN | POLLHUP | POLLERR)) != 0 &&
          recv(client, replies.data(), replies.size(), 0) <= 0)
        return true;
    }
  }

  const std::shared_ptr<server::net::EndedConnections> ended_ =
      std::make_shared<server::net::EndedConnections>();
  grpc::CallbackGenericService service_;  // knows no method
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> acceptor_;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace

std::optional<std::string> check_port(Bytes bytes) {
  static auto& port = *new PublicPort;
  if (bytes.empty()) return std::nullopt;
  std::vector<std::uint8_t> all;
  if (bytes.front() % 2 == 0) {
    const std::string greeting =
        std::string(kPreface) + frame(server::net::FrameHead::kSettings, 0, 0);
    all.assign(greeting.begin(), greeting.end());
  }
  all.insert(all.end(), bytes.begin() + 1, bytes.end());
  const auto whole = judge(all, all.size());
  const auto single = judge(all, 1);
  if (single && single != whole) return "single bytes are judged otherwise";
  if (!all.empty() && !port.take(all)) return "the connection does not end";
  return std::nullopt;
}

}  // namespace sightline::tests

// The calls of live pages: from WebSockets to the server's own services, within the process.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>

#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_set>

#include "proto/result.h"

namespace sightline::server::admin {

class TunnelCall;

/// A call from a page is a call like any other: it needs the same token, and meets the same limits.
/// Threads: any, for every member.
class Tunnel {
 public:
  static constexpr std::size_t kMaxSockets = 8;
  static constexpr std::size_t kMaxCalls = 16;  ///< Open at a time, of one socket.
  static constexpr std::size_t kMaxMessage = std::size_t{1} << 20;  ///< Bytes from a page.
  /// While more bytes than this wait for a page to read them, its calls wait.
  static constexpr std::size_t kMaxUnsent = std::size_t{4} << 20;

  /// How clients say who they are. With certificates alone there is no tunnel: a page has none.
  struct Access {
    bool tokens = false;
    bool certificates = false;
  };
  Tunnel(const std::shared_ptr<grpc::Channel>& channel, Access access)
      : stub_(channel), access_(access) {}

  /// Whether a page may open a socket. `origin`: of the page; empty for programs that are no
  /// browsers. `host`: which host the request was for. Errors: kPermissionDenied (a page from
  /// elsewhere, or under a name that an attacker may have pointed here, or certificates without
  /// tokens), kResourceExhausted.
  Status admit(std::string_view origin, std::string_view host) const;

  /// No call begins from now on. To be called before the server shuts down: gRPC 1.51 does not
  /// bear calls within the process after that.
  void stop();
  /// After stop(): cancels all calls and waits for their ends.
  void end_calls();

 private:
  friend class TunnelCall;
  friend class WebSocket;

  grpc::TemplatedGenericStub<grpc::ByteBuffer, grpc::ByteBuffer> stub_;
  const Access access_;
  std::mutex opening_;  // while a call begins
  bool stopped_ = false;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::unordered_set<TunnelCall*> calls_;
  std::size_t sockets_ = 0;
};

}  // namespace sightline::server::admin

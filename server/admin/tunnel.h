// The calls of live pages: from WebSockets to the server's own services, within the process.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_set>

#include "proto/result.h"
#include "server/exec/unread_replies.h"

namespace sightline::server::admin {

class TunnelCall;

/// A call from a page is a call like any other: it needs the same token, and meets the same limits.
/// Threads: any, for every member.
class Tunnel {
 public:
  static constexpr std::size_t kMaxSockets = 8;
  static constexpr std::size_t kMaxCalls = 16;                      ///< Open calls of one socket.
  static constexpr std::size_t kMaxMessage = std::size_t{1} << 20;  ///< Bytes from a page.
  /// While more bytes than this wait for a page to read them, or for its calls to take them, the
  /// socket is not read, and of its calls no more answers are wanted.
  static constexpr std::size_t kMaxUnsent = std::size_t{4} << 20, kMaxUntaken = kMaxUnsent;
  /// A page that is behind and gets more bytes than this is closed. A call has one answer on its
  /// way when it learns that no more are wanted.
  static constexpr std::size_t kMostUnsent = 4 * kMaxUnsent;
  /// What a message that waits costs beside its bytes.
  static constexpr std::size_t kMessageCost = 256;

  /// How clients say who they are. With certificates alone there is no tunnel: a page has none.
  struct Access {
    bool tokens = false;
    bool certificates = false;
  };
  /// `limit`: how long a page may read nothing of what waits for it, or its calls take nothing
  /// of what it has sent. It is closed then.
  Tunnel(const std::shared_ptr<grpc::Channel>& channel, Access access,
         std::chrono::milliseconds limit = exec::kReplyTimeout)
      : stub_(channel), access_(access), limit_(limit) {}

  /// Whether a page may make calls. `origin`: the page's; empty for programs that are no browsers.
  /// `host`: which host the request was for. Errors: kPermissionDenied (a page from elsewhere, or
  /// under a name that an attacker may have pointed here, or certificates without tokens).
  /// Threads: any.
  Status check_page(std::string_view origin, std::string_view host) const;
  /// Whether a page may open a socket. `address`: the peer's, without a port. When
  /// kMaxSockets are open, the newest of the address that has most is closed, if that has two more
  /// than this one. Errors: as check_page(), and kResourceExhausted. Threads: that of the pages.
  Status admit(std::string_view origin, std::string_view host, const std::string& address);

  /// No call begins from now on. Call it before the server shuts down: gRPC 1.51 does not bear
  /// calls within the process after that.
  void stop();
  /// Cancels all calls and waits for their ends. Call it after stop().
  void end_calls();

 private:
  friend class TunnelCall;
  friend class WebSocket;

  struct Page {
    std::string address;
    std::function<void()> close;
  };
  using Position = std::list<Page>::iterator;

  bool free_slot_for(const std::string& address);

  grpc::TemplatedGenericStub<grpc::ByteBuffer, grpc::ByteBuffer> stub_;
  const Access access_;
  const std::chrono::milliseconds limit_;
  std::list<Page> pages_;  // oldest first; used on the thread of the pages
  std::mutex opening_;     // held while a call begins
  bool stopped_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::unordered_set<TunnelCall*> calls_;
};

}  // namespace sightline::server::admin

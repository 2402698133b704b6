// Calls in JSON: from HTTP requests to the server's own services, within the process.
#pragma once

#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/result.h"
#include "server/admin/http_server.h"
#include "server/admin/tunnel.h"

namespace sightline::server::admin {

/// The path of a call is this and the name of its method.
inline constexpr std::string_view kJsonPath = "/v1/json/";

/// A call in JSON goes where calls of the live page go, so that it is a call like any other: it
/// needs the same token, and meets the same limits. Threads: any, for every member.
class JsonCalls {
 public:
  static constexpr std::size_t kMaxCalls = 16;                   ///< At a time; more are refused.
  static constexpr std::size_t kMaxBody = std::size_t{1} << 20;  ///< Bytes of a request.

  struct Request {
    std::string method;  ///< "GetScene".
    std::string body;
    std::string authorization;  ///< May be empty.
    std::string peer;           ///< The peer that it is made for; see exec::made_for().
    std::string timeout;        ///< In the form of gRPC's "grpc-timeout"; empty: none.
    std::vector<std::pair<std::string, std::string>> metadata;
  };
  using Done = std::function<void(const HttpReply& reply)>;

  class Call;

  /// `tunnel` outlives this object.
  explicit JsonCalls(Tunnel& tunnel) : tunnel_(tunnel) {}

  /// Whether a request may come from a page of `origin` (empty: none) at `host`. Errors: as
  /// Tunnel::check_page().
  Status check(std::string_view origin, std::string_view host) const {
    return tunnel_.check_page(origin, host);
  }

  /// Calls `done` once, on a thread of its own.
  std::shared_ptr<Call> begin(Request request, Done done);

  /// Waits for the thread. Call it when Tunnel::end_calls() has returned: no other `done` comes.
  void join();

 private:
  void start(const std::shared_ptr<Call>& call);
  void end(const std::shared_ptr<Call>& call, const HttpReply& reply);

  Tunnel& tunnel_;
  std::mutex mutex_;
  std::size_t open_ = 0;
  boost::asio::thread_pool thread_{1};  // translates one message at a time, which bounds its memory
};

/// The time of a "grpc-timeout", such as 250m for 250 ms. Errors: kInvalidArgument.
Result<std::chrono::nanoseconds> parse_timeout(const std::string& text);

}  // namespace sightline::server::admin

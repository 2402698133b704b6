// Refusals at a pace: a client that comes back at once does not keep the server busy with refusing.
#pragma once

#include <grpcpp/support/server_interceptor.h>

#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

namespace sightline::server::exec {

/// When the refusals of a connection are due. In every kRetryDelay it gets `burst` of them at once;
/// others wait. So a client that comes back after that delay, with no more calls than `burst`,
/// never waits; one that does not gets as few answers. Generic cell rate algorithm (ITU-T I.371).
///
/// A request has been received when it is refused. Refusing large ones at once, again and again,
/// takes more of the processors than the work of others does.
///
/// Threads: any, for every member.
class RefusalPace {
 public:
  using Clock = std::chrono::steady_clock;

  /// `burst` (>= 1): calls that a connection may have in flight.
  explicit RefusalPace(int burst);

  /// Counts a refusal, and returns when to answer it: `now`, or at most kRetryDelay later.
  Clock::time_point due(const std::string& connection, Clock::time_point now);
  /// Connections that were refused lately.
  std::size_t connections() const;

  /// A refusal that waits. Its owner calls leave() before it is destroyed.
  class Waiting {
   public:
    virtual ~Waiting() = default;
    /// Answers soon. Must be short and call no member of the pace.
    virtual void answer() = 0;
  };
  /// Returns false after stop(): answer now.
  bool enter(Waiting& refusal);
  void leave(Waiting& refusal);
  /// Answers all that wait. Later refusals do not wait.
  void stop();

 private:
  void forget_idle(Clock::time_point now);

  const Clock::duration interval_;
  mutable std::mutex mutex_;
  std::map<std::string, Clock::time_point> paid_until_;  // later than now: of refused connections
  std::size_t forget_at_;
  std::set<Waiting*> waiting_;
  bool stopped_ = false;
};

/// Interceptors for grpc::ServerBuilder: statuses with RetryInfo wait for `pace`, which must
/// outlive the server. The request of a unary call is freed meanwhile, by its MessageAllocator; one
/// that has none does not wait.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> pace_refusals(
    RefusalPace& pace);

}  // namespace sightline::server::exec

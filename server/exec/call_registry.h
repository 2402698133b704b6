// The open calls of one kind: at most a limit, a share of it for each caller, an end for each call
// that makes no progress, and all stopped together.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "proto/result.h"
#include "server/exec/caller.h"
#include "server/exec/shares.h"

namespace sightline::server::exec {

/// The limit of one kind of call, and the messages of its errors.
struct CallKind {
  std::size_t limit = 0;
  /// The message of the error at the limit begins with this; {} is the number of open calls.
  std::string when_full = {};
  std::string full_reason = {};  ///< Reason of that error.
  std::string when_stopped = "the server is stopping";
  /// A call that has made no progress for this long is ended where another one needs its place.
  std::chrono::steady_clock::duration gives_way = std::chrono::steady_clock::duration::max();
  bool shared = true;  ///< Each caller gets a share only.
};

/// A stream on which its client has sent nothing for this long is ended.
inline constexpr std::chrono::minutes kIdleStream{10};
/// A stream that is idle for this long is ended where another call needs its place.
inline constexpr std::chrono::seconds kIdleGivesWay{10};

/// One connection may have 1 / kConnectionCallShare of the open calls of a kind.
inline constexpr std::uint64_t kConnectionCallShare = 8;

/// Since when a call waits for its peer, and how long it may. Threads: any, for every member.
class PeerWait {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr Clock::time_point kNever = Clock::time_point::max();

  /// The call waits for its peer from now on. After `within` it is late.
  void begin(Clock::duration within) {
    const auto now = Clock::now();
    since_ = now;
    late_at_ = now + within;
  }
  /// The peer has done its part.
  void end() { since_ = late_at_ = kNever; }

  Clock::time_point since() const { return since_; }      ///< kNever: it does not wait.
  Clock::time_point late_at() const { return late_at_; }  ///< kNever: it does not wait.

 private:
  std::atomic<Clock::time_point> since_{kNever}, late_at_{kNever};
};

/// The open calls of one kind. Threads: any, for every member.
class CallRegistry {
 public:
  using Clock = std::chrono::steady_clock;

  /// Runs when the registry ends a call. It must be short and must call no member of the registry.
  struct Ends {
    std::function<void()> on_stop = {};  ///< stop() was called. May be empty.
    std::function<void()> on_late =
        {};  ///< The call is late, or gives way to another. May be empty.
  };

  explicit CallRegistry(CallKind kind);

  /// Registers a call. Where no place is free, the call of the same scope that has waited longest
  /// for its peer is ended, if it gives way. Never waits. Errors: kResourceExhausted, naming the
  /// limit; stopped_error() after stop(). `wait`: this call's, until leave(). Null: it is never
  /// late.
  Status enter(const void* call, const Caller& caller, Ends ends, const PeerWait* wait = nullptr);
  /// After it returns, no end of the call is running or will run. Does nothing for a call that is
  /// not registered.
  void leave(const void* call);

  /// Ends the calls that are late at `now`, each once.
  void end_late(Clock::time_point now = Clock::now());

  /// Ends every open call. Later calls of enter() fail.
  void stop();
  bool stopped() const;
  /// The error (kUnavailable) of a call that ends because the server stops.
  Error stopped_error() const;
  std::size_t open() const;

 private:
  struct Call {
    Caller caller;
    Ends ends;
    const PeerWait* wait = nullptr;
    bool ended = false;  // and not counted any more
  };
  using Calls = std::map<const void*, Call>;

  bool give_way(const Caller& caller, Exceeded::Scope scope);
  void end(Call& call);

  const CallKind kind_;
  mutable std::mutex mutex_;
  Calls open_;
  Shares shares_;
  bool stopped_ = false;
};

}  // namespace sightline::server::exec

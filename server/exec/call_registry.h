// The open calls of one kind: at most a limit, and all stopped together.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "accel/result.h"

namespace sightline::server::exec {

/// The limit of one kind of call, and the messages of its errors.
struct CallKind {
  std::size_t limit = 0;
  /// The message of the error at the limit begins with this; {} is the number of open calls.
  std::string when_full;
  std::string full_reason;  ///< Reason of that error.
  std::string when_stopped = "the server is stopping";
};

/// The open calls of one kind. Threads: any, for every member.
class CallRegistry {
 public:
  explicit CallRegistry(CallKind kind);

  /// Registers a call. `on_stop` (may be empty) runs if stop() is called before leave(). It must be
  /// short and must call neither enter() nor leave(). Never waits.
  /// Errors: kResourceExhausted, naming the limit; stopped_error() after stop().
  Status enter(const void* call, std::function<void()> on_stop);
  /// After it returns, the call's `on_stop` is not running and will not run. A call that is not
  /// registered: nothing to do.
  void leave(const void* call);

  /// Runs `on_stop` of every open call. Later calls of enter() fail.
  void stop();
  bool stopped() const;
  /// kUnavailable: the error of a call that ends because the server stops.
  Error stopped_error() const;

 private:
  const CallKind kind_;
  mutable std::mutex mutex_;
  std::map<const void*, std::function<void()>> open_;
  bool stopped_ = false;
};

}  // namespace sightline::server::exec

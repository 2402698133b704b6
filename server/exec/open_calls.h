// The calls of one kind that are open: so many at most, and told together when the server stops.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "accel/result.h"

namespace sightline::server::exec {

/// What a call that the server's stopping ends is told.
Error stopping();

/// Threads: any, for every member.
class CallRegistry {
 public:
  /// `what` names them in messages ("watches"), `reason` is that of the error beyond the limit.
  CallRegistry(std::size_t limit, std::string what, std::string reason);

  /// `stop` is called by stop(), if that comes before leave(); it must be short and neither enter
  /// nor leave. Errors: kResourceExhausted, at once, naming the limit; kUnavailable after stop().
  Status enter(const void* call, std::function<void()> stop);
  /// When this returns, the call's `stop` is not running and will not be called.
  void leave(const void* call);

  /// Lets no other in.
  void stop();

 private:
  const std::size_t limit_;
  const std::string what_, reason_;
  std::mutex mutex_;
  std::map<const void*, std::function<void()>> open_;
  bool stopped_ = false;
};

}  // namespace sightline::server::exec

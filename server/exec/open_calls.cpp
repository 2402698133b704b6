// The calls of one kind that are open.
#include "server/exec/open_calls.h"

#include <fmt/format.h>

#include <utility>

namespace sightline::server::exec {

Error stopping() { return {Code::kUnavailable, "the server is stopping", "STOPPING"}; }

CallRegistry::CallRegistry(std::size_t limit, std::string what, std::string reason)
    : limit_(limit), what_(std::move(what)), reason_(std::move(reason)) {}

Status CallRegistry::enter(const void* call, std::function<void()> stop) {
  const std::lock_guard lock(mutex_);
  if (stopped_) return stopping();
  if (open_.size() >= limit_) {
    return Error{Code::kResourceExhausted,
                 fmt::format("{} {} are open on the server, the limit is {}; retry later",
                             open_.size(), what_, limit_),
                 reason_};
  }
  open_.emplace(call, std::move(stop));
  return {};
}

void CallRegistry::leave(const void* call) {
  const std::lock_guard lock(mutex_);
  open_.erase(call);
}

void CallRegistry::stop() {
  const std::lock_guard lock(mutex_);
  if (std::exchange(stopped_, true)) return;
  for (const auto& [call, stop] : open_) stop();
}

}  // namespace sightline::server::exec

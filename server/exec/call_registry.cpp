// The open calls of one kind.
#include "server/exec/call_registry.h"

#include <fmt/format.h>

#include <utility>

namespace sightline::server::exec {

CallRegistry::CallRegistry(CallKind kind) : kind_(std::move(kind)) {}

Status CallRegistry::enter(const void* call, std::function<void()> on_stop) {
  const std::lock_guard lock(mutex_);
  if (stopped_) return stopped_error();
  if (open_.size() >= kind_.limit) {
    return Error{Code::kResourceExhausted,
                 fmt::format("{}, the limit is {}; retry later",
                             fmt::format(fmt::runtime(kind_.when_full), open_.size()), kind_.limit),
                 kind_.full_reason};
  }
  open_.emplace(call, std::move(on_stop));
  return {};
}

void CallRegistry::leave(const void* call) {
  const std::lock_guard lock(mutex_);
  open_.erase(call);
}

void CallRegistry::stop() {
  const std::lock_guard lock(mutex_);
  if (std::exchange(stopped_, true)) return;
  for (const auto& [call, on_stop] : open_) {
    if (on_stop) on_stop();
  }
}

bool CallRegistry::stopped() const {
  const std::lock_guard lock(mutex_);
  return stopped_;
}

Error CallRegistry::stopped_error() const {
  return {Code::kUnavailable, kind_.when_stopped, "STOPPING"};
}

}  // namespace sightline::server::exec

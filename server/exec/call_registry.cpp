// The open calls of one kind.
#include "server/exec/call_registry.h"

#include <fmt/format.h>

#include <string>
#include <utility>

namespace sightline::server::exec {

CallRegistry::CallRegistry(CallKind kind)
    : kind_(std::move(kind)),
      shares_(kind_.shared ? ShareLimits::of(kind_.limit, kConnectionCallShare)
                           : ShareLimits{kind_.limit, kind_.limit, kind_.limit}) {}

Status CallRegistry::enter(const void* call, const Caller& caller, Ends ends,
                           const PeerWait* wait) {
  const std::lock_guard lock(mutex_);
  if (stopped_) return stopped_error();
  while (const auto exceeded = shares_.exceeded(caller, 1)) {
    if (give_way(caller, exceeded->scope)) continue;
    return Error{Code::kResourceExhausted,
                 fmt::format("{}, the limit{} is {}; retry later",
                             fmt::format(fmt::runtime(kind_.when_full), exceeded->held),
                             exceeded->scope == Exceeded::Scope::kAll
                                 ? std::string()
                                 : fmt::format(" of {}", exceeded->holder()),
                             exceeded->limit),
                 kind_.full_reason};
  }
  shares_.add(caller, 1);
  open_.emplace(call, Call{.caller = caller, .ends = std::move(ends), .wait = wait});
  return {};
}

void CallRegistry::leave(const void* call) {
  const std::lock_guard lock(mutex_);
  const auto found = open_.find(call);
  if (found == open_.end()) return;
  if (!found->second.ended) shares_.remove(found->second.caller, 1);
  open_.erase(found);
}

void CallRegistry::end_late(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  for (auto& [key, call] : open_) {
    if (!call.ended && call.wait != nullptr && call.wait->late_at() <= now) end(call);
  }
}

/// Ends one call and does not count it any more.
bool CallRegistry::give_way(const Caller& caller, Exceeded::Scope scope) {
  const auto now = Clock::now();
  Call* oldest = nullptr;
  auto oldest_since = PeerWait::kNever;
  for (auto& [key, call] : open_) {
    if (call.ended || call.wait == nullptr || !is_within(caller, call.caller, scope)) continue;
    const auto since = call.wait->since();
    if (since >= oldest_since || now - since < kind_.gives_way) continue;
    oldest = &call;
    oldest_since = since;
  }
  if (oldest == nullptr) return false;
  end(*oldest);
  return true;
}

void CallRegistry::end(Call& call) {
  call.ended = true;
  shares_.remove(call.caller, 1);
  if (call.ends.on_late) call.ends.on_late();
}

void CallRegistry::stop() {
  const std::lock_guard lock(mutex_);
  if (std::exchange(stopped_, true)) return;
  for (const auto& [key, call] : open_) {
    if (call.ends.on_stop) call.ends.on_stop();
  }
}

bool CallRegistry::stopped() const {
  const std::lock_guard lock(mutex_);
  return stopped_;
}

std::size_t CallRegistry::open() const {
  const std::lock_guard lock(mutex_);
  return open_.size();
}

Error CallRegistry::stopped_error() const {
  return {Code::kUnavailable, kind_.when_stopped, "STOPPING"};
}

}  // namespace sightline::server::exec

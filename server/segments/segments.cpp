// The segments that clients on this machine share with the server.
#include "server/segments/segments.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "server/exec/rpc_status.h"
#include "server/segments/random_bytes.h"

namespace sightline::server::segments {
namespace {

Error not_offered(std::string_view to) {
  return {Code::kFailedPrecondition,
          fmt::format("this server offers segments {}: see --segments; send rays in messages", to),
          "SEGMENTS_NOT_OFFERED"};
}

}  // namespace

Segments::Segments(exec::MemoryAccount& memory, Offer offer)
    : offer_(offer),
      account_(memory),
      calls_({.limit = kMaxSegments,
              .when_full = "{} segments are open on the server",
              .full_reason = kTooManySegments}) {
  if (offer_ == Offer::kOff) return;
  if (!Segment::is_safe()) {
    spdlog::warn("event=no_segments reason=\"vm.overcommit_memory is 2\"");
    offer_ = Offer::kOff;
    return;
  }
  try {
    handover_.emplace(keys_);
  } catch (const std::exception& thrown) {
    spdlog::warn("event=no_segments reason=\"{}\"", thrown.what());
    offer_ = Offer::kOff;
  }
}

Status Segments::check_offered(std::string_view peer) const {
  if (offer_ == Offer::kOff) return not_offered("to no client");
  if (includes(offer_, peer)) return {};
  return not_offered(offer_ == Offer::kUnix ? "to clients at its Unix socket alone"
                                            : "to clients of this machine alone");
}

std::uint64_t Segments::most() const {
  const std::uint64_t bytes = std::min(kMaxSegmentBytes, account_.share());
  return bytes / page_size() * page_size();
}

std::uint64_t Segments::max_bytes(std::string_view peer) const {
  return check_offered(peer) ? most() : 0;
}

Result<Segments::Opened> Segments::open(const exec::Caller& caller, std::uint64_t bytes) {
  if (bytes == 0)
    return exec::invalid_argument("a segment of 0 bytes is asked for", "SEGMENT_EMPTY");
  if (bytes > most()) {
    return Error{Code::kResourceExhausted,
                 fmt::format("a segment of {} bytes is asked for, the limit is {}", bytes, most()),
                 "SEGMENT_TOO_LARGE"};
  }
  const std::uint64_t size = (bytes + page_size() - 1) / page_size() * page_size();
  auto held = account_.hold(caller, size);
  if (!held) return held.error();
  auto segment = Segment::make(size, caller.principal, std::move(*held));
  if (!segment) return segment.error();
  Opened opened{std::move(*segment), random_name(), {}};
  opened.key = keys_.add(opened.segment);
  const std::lock_guard lock(mutex_);
  open_.emplace(opened.name, opened.segment);
  return opened;
}

void Segments::close(const std::string& name) {
  std::shared_ptr<const Segment> closed;  // ends after the lock
  const std::lock_guard lock(mutex_);
  const auto found = open_.find(name);
  if (found == open_.end()) return;
  closed = std::move(found->second);
  open_.erase(found);
}

Result<std::shared_ptr<const Segment>> Segments::find(const std::string& name,
                                                      const exec::Caller& caller) const {
  if (offer_ == Offer::kOff) return not_offered("to no client");
  {
    const std::lock_guard lock(mutex_);
    const auto found = open_.find(name);
    if (found != open_.end() && found->second->principal() == caller.principal)
      return found->second;
  }
  if (calls_.stopped()) return calls_.stopped_error();
  return Error{Code::kNotFound,
               fmt::format("no segment {} is open: its OpenSegment call has ended, or is one of "
                           "another principal",
                           exec::quote(name)),
               "SEGMENT_NOT_FOUND"};
}

}  // namespace sightline::server::segments

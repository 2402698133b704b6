// Asks once what the server offers, and opens segments when blocks find no room.
#include "client/calls/segment_pool.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "client/calls/connection.h"

namespace sightline::client::calls {
namespace {

constexpr std::chrono::milliseconds kFirstAskPause{1000};
constexpr std::chrono::milliseconds kLongestAskPause{60'000};
constexpr std::chrono::seconds kLongestWait{5};  // for an answer to a call without work

std::chrono::system_clock::time_point end_of(const SegmentWait& wait) {
  const auto longest = std::chrono::system_clock::now() + kLongestWait;
  return wait.deadline ? std::min(*wait.deadline, longest) : longest;
}

}  // namespace

SegmentPool::SegmentPool(std::shared_ptr<grpc::Channel> channel, std::string refusal)
    : channel_(std::move(channel)), refusal_(std::move(refusal)), pause_(kFirstAskPause) {}

std::string SegmentPool::refusal_of(const Endpoint& endpoint, const ClientOptions& options) {
  if (!options.use_segments) return "ClientOptions::use_segments is off";
  if (endpoint.is_balanced()) return "the endpoint has, or may have, several servers";
  if (!endpoint.is_local()) return "the endpoint is not on this machine";
  return {};
}

std::optional<SegmentLimits> SegmentPool::limits(const SegmentWait& wait) {
  if (!refusal_.empty()) return std::nullopt;
  if (const auto known = known_limits()) return known;
  const std::unique_lock asking(asking_, end_of(wait));
  if (!asking) return std::nullopt;
  if (const auto known = known_limits()) return known;
  if (!may_ask()) return std::nullopt;
  const auto asked = ask(wait);
  if (!asked && wait.stop.stop_requested()) return std::nullopt;
  if (!asked) return note_failure(asked.error()), std::nullopt;
  const std::lock_guard lock(mutex_);
  limits_ = *asked;
  return limits_;
}

std::optional<SegmentLimits> SegmentPool::known_limits() {
  const std::lock_guard lock(mutex_);
  return limits_;
}

Result<SegmentLimits> SegmentPool::ask(const SegmentWait& wait) const {
  grpc::ClientContext context;
  context.set_deadline(end_of(wait));
  const std::stop_callback cancel(wait.stop, [&] { context.TryCancel(); });
  v1::GetServerInfoResponse info;
  const grpc::Status status = v1::ServerService::NewStub(channel_)->GetServerInfo(
      &context, v1::GetServerInfoRequest(), &info);
  if (!status.ok()) return rpc_error(status, wait.stop);
  if (info.max_segment_bytes() == 0 || info.max_rays_per_shared_request() == 0) {
    return Error{Code::kFailedPrecondition, "the server offers no segments to this client",
                 "SEGMENTS_NOT_OFFERED"};
  }
  return SegmentLimits{info.max_segment_bytes(), info.max_rays_per_shared_request(),
                       info.max_rays_per_request()};
}

std::optional<SegmentBlock> SegmentPool::take(std::uint64_t bytes, const SegmentWait& wait) {
  if (auto block = take_from_open(bytes)) return block;
  const std::unique_lock asking(asking_, std::try_to_lock);
  const auto limits = known_limits();
  if (!asking || !limits || !may_ask()) return std::nullopt;
  const std::uint64_t size = std::min(kSegmentBytes, limits->segment_bytes);
  {
    const std::lock_guard lock(mutex_);
    if (bytes > size || pool_.size() >= kMostSegments) return std::nullopt;
  }
  const auto opened = Segment::open(channel_, size, end_of(wait), wait.stop);
  if (!opened && wait.stop.stop_requested()) return std::nullopt;
  if (!opened) return note_failure(opened.error()), std::nullopt;
  auto data = (*opened)->take(bytes);
  const std::lock_guard lock(mutex_);
  pool_.push_back(*opened);
  failure_.clear();
  pause_ = kFirstAskPause;
  if (data == nullptr) return std::nullopt;
  return SegmentBlock{*opened, std::move(data)};
}

/// Segments that are lost or abandoned go with the last block of them.
std::optional<SegmentBlock> SegmentPool::take_from_open(std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  std::erase_if(pool_, [](const auto& segment) { return !segment->is_shared(); });
  for (const std::shared_ptr<Segment>& segment : pool_) {
    if (auto data = segment->take(bytes)) return SegmentBlock{segment, std::move(data)};
  }
  return std::nullopt;
}

bool SegmentPool::may_ask() {
  const std::lock_guard lock(mutex_);
  return Clock::now() >= ask_again_;
}

void SegmentPool::note_failure(const Error& error) {
  const std::lock_guard lock(mutex_);
  failure_ = error.message.empty() ? name_of(error.code) : error.message;
  ask_again_ = Clock::now() + pause_;
  pause_ = std::min(2 * pause_, kLongestAskPause);
}

Result<std::shared_ptr<Segment>> SegmentPool::share(std::uint64_t bytes) {
  if (!refusal_.empty()) return Segment::unshared(bytes, refusal_);
  const std::lock_guard asking(asking_);
  auto limits = known_limits();
  if (!limits) {
    const auto asked = ask({});
    if (!asked) return Segment::unshared(bytes, asked.error().message);
    limits = *asked;
  }
  if (bytes > limits->segment_bytes) {
    return Segment::unshared(
        bytes, fmt::format("{} bytes are more than the {} of the largest segment of the server",
                           bytes, limits->segment_bytes));
  }
  auto opened = Segment::open(channel_, bytes, end_of({}), {});
  if (!opened) return Segment::unshared(bytes, opened.error().message);
  const std::lock_guard lock(mutex_);
  limits_ = limits;
  std::erase_if(users_, [](const auto& segment) { return segment.expired(); });
  users_.push_back(*opened);
  has_shared_ = true;
  return opened;
}

std::shared_ptr<Segment> SegmentPool::find(const void* address) {
  if (!has_shared_) return nullptr;
  const std::lock_guard lock(mutex_);
  for (const std::weak_ptr<Segment>& user : users_) {
    if (auto segment = user.lock(); segment != nullptr && segment->contains(address, 1))
      return segment;
  }
  return nullptr;
}

void SegmentPool::lose(Segment& segment) {
  segment.lose();
  const std::lock_guard lock(mutex_);
  limits_.reset();
  pause_ = kFirstAskPause;
  ask_again_ = {};
}

TransportChoice SegmentPool::transport() {
  if (!refusal_.empty()) return {Transport::kMessages, refusal_};
  const std::lock_guard lock(mutex_);
  const auto is_shared = [](const auto& segment) {
    return segment != nullptr && segment->is_shared();
  };
  const bool has_one = std::any_of(pool_.begin(), pool_.end(), is_shared) ||
                       std::any_of(users_.begin(), users_.end(),
                                   [&](const auto& segment) { return is_shared(segment.lock()); });
  if (has_one) return {Transport::kSegments, "client and server share memory"};
  return {Transport::kMessages, failure_.empty() ? "no cast has needed shared memory" : failure_};
}

}  // namespace sightline::client::calls

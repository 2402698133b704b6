// A mapping, the call that keeps it at the server, and the blocks in it.
#include "client/calls/segment.h"

#include <fmt/format.h>

#include <utility>

namespace sightline::client::calls {

Segment::Segment(ReceivedSegment received, std::unique_ptr<SegmentCall> call, std::string reason)
    : connection_(std::move(received.connection)),
      memory_(std::move(received.memory)),
      server_(std::move(received.server)),
      call_(std::move(call)),
      name_(call_ == nullptr ? std::string() : call_->opened().segment()),
      reason_(std::move(reason)),
      state_(call_ == nullptr ? State::kUnshared : State::kShared),
      blocks_(memory_.size()) {}

Result<std::shared_ptr<Segment>> Segment::open(const std::shared_ptr<grpc::Channel>& channel,
                                               std::uint64_t bytes,
                                               std::chrono::system_clock::time_point deadline,
                                               const std::stop_token& stop) {
  auto call = SegmentCall::open(channel, bytes, deadline, stop);
  if (!call) return call.error();
  const v1::OpenSegmentResponse& opened = (*call)->opened();
  if (opened.segment().empty() || opened.bytes() < bytes) {
    return Error{Code::kInternal,
                 fmt::format("the server has opened a segment '{}' of {} bytes instead of {}",
                             opened.segment(), opened.bytes(), bytes),
                 {}};
  }
  auto received = receive_segment(opened.socket(), opened.key(), opened.bytes(), deadline);
  if (!received) return received.error();
  return std::shared_ptr<Segment>(new Segment(*std::move(received), *std::move(call), {}));
}

Result<std::shared_ptr<Segment>> Segment::unshared(std::uint64_t bytes, std::string reason) {
  auto memory = Mapping::anonymous(bytes);
  if (!memory) return memory.error();
  return std::shared_ptr<Segment>(
      new Segment({Descriptor(), *std::move(memory), {}}, nullptr, std::move(reason)));
}

std::string Segment::why_not_shared() const {
  switch (state_) {
    case State::kShared:
      return {};
    case State::kUnshared:
      return reason_;
    case State::kLost:
      return "the server that had it is gone, or has taken it back";
    case State::kAbandoned:
      return "a cast that used it failed, and the server may still write to it";
  }
  return {};
}

void Segment::lose() {
  State shared = State::kShared;
  state_.compare_exchange_strong(shared, State::kLost);
}

void Segment::abandon() {
  if (call_ != nullptr) state_ = State::kAbandoned;
}

std::shared_ptr<std::byte> Segment::take(std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  if (is_abandoned()) return nullptr;
  const auto offset = blocks_.take(bytes);
  if (!offset) return nullptr;
  return {memory_.data() + *offset,
          [owner = shared_from_this(), offset = *offset, bytes](std::byte*) {
            const std::lock_guard released(owner->mutex_);
            owner->blocks_.release(offset, bytes);
          }};
}

bool Segment::contains(const void* data, std::uint64_t bytes) const {
  const auto begin = reinterpret_cast<std::uintptr_t>(memory_.data());
  const auto at = reinterpret_cast<std::uintptr_t>(data);
  return at >= begin && at - begin <= size() && bytes <= size() - (at - begin);
}

}  // namespace sightline::client::calls

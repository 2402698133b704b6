// Memory that a client and its server both map. Internal to the library.
#pragma once

#include <grpcpp/channel.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>

#include "client/calls/block_list.h"
#include "client/calls/descriptor.h"
#include "client/calls/segment_call.h"
#include "client/calls/segment_handover.h"
#include "client/result.h"

namespace sightline::client::calls {

/// Blocks of it keep it. Threads: any, for every member.
class Segment : public std::enable_shared_from_this<Segment> {
 public:
  /// Asks the server for a segment. Errors: as SegmentCall::open() and receive_segment().
  static Result<std::shared_ptr<Segment>> open(const std::shared_ptr<grpc::Channel>& channel,
                                               std::uint64_t bytes,
                                               std::chrono::system_clock::time_point deadline,
                                               const std::stop_token& stop);
  /// Memory of this process alone, with the reason why. Errors: kResourceExhausted.
  static Result<std::shared_ptr<Segment>> unshared(std::uint64_t bytes, std::string reason);

  /// What requests call it.
  const std::string& name() const { return name_; }
  std::uint64_t size() const { return memory_.size(); }

  /// Whether requests may name it.
  bool is_shared() const { return state_ == State::kShared; }
  /// Whether the server may still write to it for a call that is over here.
  bool is_abandoned() const { return state_ == State::kAbandoned; }
  /// Why it is not shared; empty if it is.
  std::string why_not_shared() const;

  /// Whether the server's process has certainly ended, now or within the time.
  bool has_server_ended(std::chrono::milliseconds within) const {
    return server_.has_ended(within);
  }
  /// The server does not know it any more.
  void lose();
  /// A call that named it ended here, and perhaps not at the server. From now on no request names
  /// it, and no block of it is taken.
  void abandon();

  /// A block that is released with its last owner. Null: there is no room.
  std::shared_ptr<std::byte> take(std::uint64_t bytes);

  bool contains(const void* data, std::uint64_t bytes) const;
  /// Of memory that it contains.
  std::uint64_t offset_of(const void* data) const {
    return static_cast<std::uint64_t>(static_cast<const std::byte*>(data) - memory_.data());
  }

 private:
  enum class State : std::uint8_t { kShared, kUnshared, kLost, kAbandoned };

  Segment(ReceivedSegment received, std::unique_ptr<SegmentCall> call, std::string reason);

  const Descriptor connection_;  ///< Closed when memory_ is unmapped. None if it was never shared.
  const Mapping memory_;
  const ServerProcess server_;
  const std::unique_ptr<SegmentCall> call_;  ///< Null if it was never shared.
  const std::string name_;
  const std::string reason_;
  std::atomic<State> state_;
  std::mutex mutex_;
  BlockList blocks_;  ///< Under mutex_.
};

}  // namespace sightline::client::calls

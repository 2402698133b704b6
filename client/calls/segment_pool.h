// The segments of a client, and whether it has any. Internal to the library.
#pragma once

#include <grpcpp/channel.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "client/calls/endpoint.h"
#include "client/calls/segment.h"
#include "client/client.h"
#include "client/shared_memory.h"

namespace sightline::client::calls {

/// What a server says about casts and segments.
struct SegmentLimits {
  std::uint64_t segment_bytes = 0;
  std::uint64_t rows = 0;             ///< Of a request by a segment.
  std::uint64_t rows_of_message = 0;  ///< Of another request.
};

struct SegmentBlock {
  std::shared_ptr<Segment> segment;
  std::shared_ptr<std::byte> data;
};

/// When a wait for a server ends.
struct SegmentWait {
  std::optional<std::chrono::system_clock::time_point> deadline{};
  std::stop_token stop{};
};

/// Opens segments when casts need them. A thread that would wait for room, or for another one that
/// opens a segment, gets none instead; what the server offers is asked once, and waited for. After
/// a failure the server is asked again a second later, and later each time. Threads: any, for every
/// member.
class SegmentPool {
 public:
  static constexpr std::uint64_t kSegmentBytes = std::uint64_t{32} << 20;
  static constexpr std::size_t kMostSegments = 4;

  /// `refusal`: why the client uses no segments, whatever the server offers. Empty: nothing speaks
  /// against them.
  SegmentPool(std::shared_ptr<grpc::Channel> channel, std::string refusal);

  /// What speaks against segments for a client of these options; empty: nothing.
  static std::string refusal_of(const Endpoint& endpoint, const ClientOptions& options);

  /// Nothing: casts go by messages. The first call asks the server.
  std::optional<SegmentLimits> limits(const SegmentWait& wait);
  /// A block for the rows of a cast. Nothing: there is no room.
  std::optional<SegmentBlock> take(std::uint64_t bytes, const SegmentWait& wait);

  /// Memory for a user: a segment of its own, or else memory that is not shared, with the reason.
  /// Errors: kResourceExhausted.
  Result<std::shared_ptr<Segment>> share(std::uint64_t bytes);
  /// Whether share() has ever given a segment.
  bool has_shared() const { return has_shared_; }
  /// The user's segment that has this address. Null: none.
  std::shared_ptr<Segment> find(const void* address);

  /// The server does not know the segment any more.
  void lose(Segment& segment);

  TransportChoice transport();

 private:
  using Clock = std::chrono::steady_clock;

  std::optional<SegmentLimits> known_limits();
  Result<SegmentLimits> ask(const SegmentWait& wait) const;
  std::optional<SegmentBlock> take_from_open(std::uint64_t bytes);
  bool may_ask();
  void note_failure(const Error& error);

  const std::shared_ptr<grpc::Channel> channel_;
  const std::string refusal_;
  std::atomic<bool> has_shared_ = false;
  std::timed_mutex asking_;  ///< Held by the thread that waits for the server.
  std::mutex mutex_;         ///< For all below.
  std::optional<SegmentLimits> limits_;
  std::vector<std::shared_ptr<Segment>> pool_;
  std::vector<std::weak_ptr<Segment>> users_;
  std::string failure_;  ///< The last one since a segment was opened.
  std::chrono::milliseconds pause_;
  Clock::time_point ask_again_;
};

}  // namespace sightline::client::calls

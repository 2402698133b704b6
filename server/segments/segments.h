// The segments that clients on this machine share with the server.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "proto/result.h"
#include "server/exec/call_registry.h"
#include "server/exec/caller.h"
#include "server/exec/memory_account.h"
#include "server/segments/handover.h"
#include "server/segments/handover_keys.h"
#include "server/segments/offer.h"
#include "server/segments/segment.h"
#include "server/segments/segment_account.h"

namespace sightline::server::segments {

/// Bytes of one segment. Two requests of the most rays, with every column in float64 and every
/// field, take 74 MiB: a client fills one while the server answers the other.
inline constexpr std::uint64_t kMaxSegmentBytes = std::uint64_t{128} << 20;

/// Threads: any, for every member.
class Segments {
 public:
  /// Listens for clients that get segments, unless none is offered any. Where the system does not
  /// let it, the log says so, and none is. `memory` outlives this object.
  Segments(exec::MemoryAccount& memory, Offer offer);

  /// Errors: kFailedPrecondition (SEGMENTS_NOT_OFFERED). `peer`: as gRPC writes it.
  Status check_offered(std::string_view peer) const;
  /// The most bytes of one segment, whole pages. 0: the server offers none to this peer.
  std::uint64_t max_bytes(std::string_view peer) const;

  struct Opened {
    std::shared_ptr<const Segment> segment;
    std::string name;
    HandoverKeys::Key key{};
  };
  /// Makes a segment of at least this many bytes, which lives until close(), the end of the
  /// connection by which its client has it, and its last user. May take long. Errors:
  /// kInvalidArgument (no bytes), kResourceExhausted.
  Result<Opened> open(const exec::Caller& caller, std::uint64_t bytes);
  /// From now on no request finds the segment. Does nothing for a name that is not open. May take
  /// long, as the pages go back.
  void close(const std::string& name);

  /// The open segment of this name and principal, for a request that uses it until it is answered.
  /// Errors: kFailedPrecondition (SEGMENTS_NOT_OFFERED: to no client); kNotFound; kUnavailable, if
  /// the server is stopping and has ended it for that.
  Result<std::shared_ptr<const Segment>> find(const std::string& name,
                                              const exec::Caller& caller) const;

  /// The name of the socket at which keys are taken, without the zero byte before it. Some segment
  /// was opened.
  const std::string& socket() const { return handover_->name(); }
  /// Segments that hold memory, those that have ended and are still mapped included.
  std::size_t count() const { return account_.count(); }
  /// The calls that keep segments open.
  exec::CallRegistry& calls() { return calls_; }
  const exec::CallRegistry& calls() const { return calls_; }

 private:
  std::uint64_t most() const;

  Offer offer_;  // kOff, if the system does not let it
  SegmentAccount account_;
  exec::CallRegistry calls_;
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<const Segment>> open_;  // protected by mutex_
  HandoverKeys keys_;
  std::optional<Handover> handover_;  // none: no client is offered any. Last: uses keys_
};

}  // namespace sightline::server::segments

// Replies that were handed to gRPC and are not gone yet: their bytes are bounded, and so is the
// time that a peer may take to read them.
#pragma once

#include <grpcpp/server_context.h>

#include <chrono>
#include <cstdint>
#include <memory>

#include "proto/result.h"
#include "server/exec/admission.h"
#include "server/exec/call_registry.h"
#include "server/exec/caller.h"

namespace sightline::server::exec {

/// A peer that has not read a reply after this long is given up: its call is cancelled.
inline constexpr std::chrono::seconds kReplyTimeout{30};

/// Threads: any, for every member.
class UnreadReplies {
 public:
  static constexpr std::uint64_t kSmall = std::uint64_t{64} << 10;

  /// At most `bytes` of replies on the server, and beside them `for_small` of replies up to kSmall,
  /// which have room whatever others hold. `memory` may be null.
  explicit UnreadReplies(std::uint64_t bytes, MemoryAccount* memory = nullptr,
                         std::uint64_t for_small = 0);

  /// A reply that its peer has not read; the destructor says that it has. It must be destroyed
  /// before its call's context, and outside of every lock that a reaction to the call's
  /// cancellation takes.
  class Held {
   public:
    Held(UnreadReplies& replies, grpc::CallbackServerContext& context, Admission::Ticket ticket);
    ~Held();
    Held(const Held&) = delete;
    Held& operator=(const Held&) = delete;

   private:
    UnreadReplies& replies_;
    const Admission::Ticket ticket_;
    PeerWait wait_;
  };

  /// Call it before a reply is written. `bytes`: what the call holds until it is read. Errors:
  /// kResourceExhausted: the connection, its principal or the server has too many unread bytes.
  Result<std::unique_ptr<Held>> hold(grpc::CallbackServerContext& context, const Caller& caller,
                                     std::uint64_t bytes);

  /// Holds a reply that must be written: never refused. Beyond the limits its bytes do not count,
  /// but its time does.
  std::unique_ptr<Held> hold_in_any_case(grpc::CallbackServerContext& context, const Caller& caller,
                                         std::uint64_t bytes);

  /// Cancels the calls whose replies are not read in time.
  void end_late(CallRegistry::Clock::time_point now = CallRegistry::Clock::now()) {
    open_.end_late(now);
  }
  std::uint64_t bytes() const { return admission_.in_flight().bytes + small_.in_flight().bytes; }

 private:
  Result<Admission::Ticket> admit(const Caller& caller, std::uint64_t bytes);

  Admission admission_, small_;
  CallRegistry open_;
};

}  // namespace sightline::server::exec

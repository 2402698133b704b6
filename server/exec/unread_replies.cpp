// Replies that were handed to gRPC and are not gone yet.
#include "server/exec/unread_replies.h"

#include <limits>
#include <utility>

namespace sightline::server::exec {

UnreadReplies::UnreadReplies(std::uint64_t bytes, MemoryAccount* memory, std::uint64_t for_small)
    : admission_({std::numeric_limits<std::uint64_t>::max(), bytes}, memory),
      small_({std::numeric_limits<std::uint64_t>::max(), for_small}, memory,
             Admission::Capacity::kReserved),
      open_({.limit = std::numeric_limits<std::size_t>::max(), .shared = false}) {}

UnreadReplies::Held::Held(UnreadReplies& replies, grpc::CallbackServerContext& context,
                          Admission::Ticket ticket)
    : replies_(replies), ticket_(std::move(ticket)) {
  wait_.begin(kReplyTimeout);
  // Without a limit nothing is refused.
  static_cast<void>(
      replies_.open_.enter(this, {}, {.on_late = [&context] { context.TryCancel(); }}, &wait_));
}

UnreadReplies::Held::~Held() { replies_.open_.leave(this); }

Result<Admission::Ticket> UnreadReplies::admit(const Caller& caller, std::uint64_t bytes) {
  auto ticket = admission_.admit(caller, 0, bytes);
  if (ticket || bytes > kSmall) return ticket;
  auto small = small_.admit(caller, 0, bytes);
  return small ? std::move(small) : std::move(ticket);
}

Result<std::unique_ptr<UnreadReplies::Held>> UnreadReplies::hold(
    grpc::CallbackServerContext& context, const Caller& caller, std::uint64_t bytes) {
  auto ticket = admit(caller, bytes);
  if (!ticket) {
    Error error = ticket.error();
    error.message = "replies are not read: " + error.message;
    return error;
  }
  return std::make_unique<Held>(*this, context, std::move(*ticket));
}

std::unique_ptr<UnreadReplies::Held> UnreadReplies::hold_in_any_case(
    grpc::CallbackServerContext& context, const Caller& caller, std::uint64_t bytes) {
  auto ticket = admit(caller, bytes);
  return std::make_unique<Held>(*this, context, ticket ? std::move(*ticket) : Admission::Ticket());
}

}  // namespace sightline::server::exec

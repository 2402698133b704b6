// A call of the admin port, in the form that fits every method: streams of bytes both ways.
#include "server/admin/tunnel_call.h"

#include <grpcpp/support/slice.h>

#include <utility>
#include <vector>

#include "proto/printable.h"
#include "server/exec/made_for.h"

namespace sightline::server::admin {

Result<std::shared_ptr<TunnelCall>> TunnelCall::open(Tunnel& tunnel, const Request& request,
                                                     Events events) {
  if (!is_printable(request.authorization)) {
    return Error{Code::kUnauthenticated,
                 "the token has characters other than visible ASCII: it is none", "TOKEN_UNKNOWN"};
  }
  for (const auto& [name, value] : request.metadata) {
    if (is_printable(value)) continue;
    return Error{Code::kInvalidArgument,
                 "the header " + name + " has characters other than visible ASCII", "BAD_HEADER"};
  }
  const std::lock_guard opening(tunnel.opening_);
  if (tunnel.stopped_) return Error{Code::kUnavailable, "the server stops", "STOPPING"};
  std::shared_ptr<TunnelCall> made(new TunnelCall(tunnel, std::move(events)));
  made->self_ = made;
  if (!request.authorization.empty())
    made->context_.AddMetadata("authorization", request.authorization);
  made->context_.AddMetadata(exec::kMadeFor, exec::made_for(request.peer));
  for (const auto& [name, value] : request.metadata) made->context_.AddMetadata(name, value);
  if (request.deadline) made->context_.set_deadline(*request.deadline);
  {
    const std::lock_guard lock(tunnel.mutex_);
    tunnel.calls_.insert(made.get());
  }
  tunnel.stub_.PrepareBidiStreamingCall(&made->context_, request.method, {}, made.get());
  made->AddHold();  // messages are sent and wanted from other threads, until the last has come
  made->StartRead(&made->incoming_);
  made->StartCall();
  return made;
}

std::size_t TunnelCall::send(const std::optional<std::string>& message, bool last) {
  const std::size_t bytes = message ? message->size() + Tunnel::kMessageCost : 0;
  Outgoing next{.message = {}, .bytes = bytes, .last = last};
  if (message) {
    const grpc::Slice slice(*message);
    next.message.emplace(&slice, 1);
  }
  const std::lock_guard lock(mutex_);
  if (over_ || closed_) return 0;
  closed_ = last;
  outgoing_.push_back(std::move(next));
  if (outgoing_.size() == 1) write_next();
  return bytes;
}

/// The caller holds the lock.
void TunnelCall::write_next() {
  const Outgoing& next = outgoing_.front();
  if (!next.message) {
    StartWritesDone();
  } else if (next.last) {
    StartWriteLast(&*next.message, {});
  } else {
    StartWrite(&*next.message);
  }
}

void TunnelCall::OnWriteDone(bool ok) {
  std::size_t bytes = 0;
  {
    const std::lock_guard lock(mutex_);
    bytes = outgoing_.front().bytes;
    outgoing_.pop_front();
    if (!ok || over_) {
      for (const Outgoing& dropped : outgoing_) bytes += dropped.bytes;
      outgoing_.clear();
      closed_ = true;
    }
    if (!outgoing_.empty()) write_next();
  }
  events_.taken(bytes);
}

void TunnelCall::want_next() {
  const std::lock_guard lock(mutex_);
  if (over_ || reading_) return;
  reading_ = true;
  StartRead(&incoming_);
}

void TunnelCall::cancel() {
  context_.TryCancel();
  const std::lock_guard lock(mutex_);
  cancelled_ = true;
  if (!reading_) start_no_more();
}

/// The caller holds the lock. The call ends once it has its status.
void TunnelCall::start_no_more() {
  if (over_) return;
  over_ = true;
  RemoveHold();
}

void TunnelCall::OnReadDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    // No one reads a message that was on its way when the call was cancelled. Another read would
    // fail and end the call, too, but gRPC 1.51 aborted at times when the server stopped then.
    if (!ok || cancelled_) return start_no_more();
  }
  std::vector<grpc::Slice> slices;
  std::string message;
  if (incoming_.Dump(&slices).ok()) {
    message.reserve(incoming_.Length());
    for (const grpc::Slice& slice : slices)
      message.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  incoming_.Clear();
  {
    const std::lock_guard lock(mutex_);
    reading_ = false;
    if (cancelled_) return start_no_more();
  }
  events_.message(std::move(message));
}

void TunnelCall::OnDone(const grpc::Status& status) {
  events_.ended(status);
  const std::shared_ptr<TunnelCall> self = std::move(self_);
  const std::lock_guard lock(tunnel_.mutex_);
  tunnel_.calls_.erase(this);
  tunnel_.changed_.notify_all();
}

}  // namespace sightline::server::admin

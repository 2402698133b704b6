// Pings a server, and counts the pings that it does not answer.
#include "server/shards/peer.h"

#include <fmt/format.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/slice.h>
#include <grpcpp/support/stub_options.h>
#include <spdlog/spdlog.h>

#include <utility>

namespace sightline::server::shards {
namespace {

constexpr const char* kHealthCheck = "/grpc.health.v1.Health/Check";

/// The request without a field, which asks about the server as a whole.
grpc::ByteBuffer empty_message() {
  const grpc::Slice nothing;
  return {&nothing, 1};
}

void cancel(const std::vector<Peer::Context>& calls) {
  for (const Peer::Context& call : calls) call->TryCancel();
}

}  // namespace

Peer::Peer(std::string address, Connect connect)
    : address_(std::move(address)),
      connect_(std::move(connect)),
      stub_(v1::RayQueryService::NewStub(connect_())) {}

Peer::~Peer() {
  std::vector<LinePointer> ended;  // destroyed last
  std::unique_lock lock(mutex_);
  for (LinePointer* line : {&line_, &attempt_}) {
    if (*line != nullptr) retired_.push_back(std::move(*line));
  }
  const std::vector<Context> open = retire_lines(ended);
  lock.unlock();
  cancel(open);
  lock.lock();
  ping_ended_.wait(lock, [this] { return open_pings_ == 0; });
}

Peer::LinePointer Peer::connect() const {
  auto line = std::make_unique<Line>();
  line->channel = connect_();
  line->request = empty_message();
  return line;
}

void Peer::ping() {
  std::vector<LinePointer> ended;
  std::vector<Context> cancelled;
  std::vector<Line*> lines;  // they end in this function
  {
    const std::lock_guard lock(mutex_);
    if (line_ == nullptr) line_ = connect();
    if (unanswered_ >= kPingsUntilLost && !std::exchange(lost_, true)) {
      cancelled.assign(calls_.begin(), calls_.end());
      spdlog::warn("event=shard_peer_lost peer={} pings={} calls_ended={} error={}", address_,
                   unanswered_, cancelled.size(), failure_);
    }
    if (lost_ && unanswered_ % kPingsOfAttempt == 0) {
      if (attempt_ != nullptr) retired_.push_back(std::move(attempt_));
      attempt_ = connect();
    }
    ++unanswered_;
    for (Context& open : retire_lines(ended)) cancelled.push_back(std::move(open));
    lines = {line_.get(), attempt_.get()};
  }
  cancel(cancelled);  // without the mutex: calls that end may say so in this thread
  for (Line* const line : lines) {
    if (line != nullptr) send(*line);
  }
}

/// Gives away the lines without an open ping, and the open pings of the others. The caller holds
/// the mutex.
std::vector<Peer::Context> Peer::retire_lines(std::vector<LinePointer>& ended) {
  std::vector<Context> open;
  for (LinePointer& line : retired_) {
    if (line->open) {
      open.push_back(line->context);
    } else {
      ended.push_back(std::move(line));
    }
  }
  std::erase(retired_, nullptr);
  return open;
}

void Peer::send(Line& line) {
  const auto context = std::make_shared<grpc::ClientContext>();
  Context before;
  {
    const std::lock_guard lock(mutex_);
    if (line.open) return;  // it answers that one when it lives again
    before = std::exchange(line.context, context);
    line.open = true;
    ++open_pings_;
  }
  grpc::GenericStub(line.channel)
      .UnaryCall(context.get(), kHealthCheck, grpc::StubOptions(), &line.request, &line.reply,
                 [this, &line](const grpc::Status& status) { end_ping(line, status); });
}

void Peer::end_ping(Line& line, const grpc::Status& status) {
  const std::lock_guard lock(mutex_);
  line.open = false;
  --open_pings_;
  ping_ended_.notify_all();
  if (&line != line_.get() && &line != attempt_.get()) return;
  if (!status.ok()) {
    failure_ = status.error_message();
    return;
  }
  if (attempt_ != nullptr) {
    if (&line == attempt_.get()) std::swap(line_, attempt_);
    retired_.push_back(std::move(attempt_));
  }
  hear();
}

/// Notes that the peer has answered. The caller holds the mutex.
void Peer::hear() {
  unanswered_ = 0;
  failure_.clear();
  if (!std::exchange(lost_, false)) return;
  spdlog::info("event=shard_peer_found peer={}", address_);
  stub_ = v1::RayQueryService::NewStub(connect_());
}

std::uint32_t Peer::unanswered() const {
  const std::lock_guard lock(mutex_);
  return unanswered_;
}

bool Peer::is_lost() const {
  const std::lock_guard lock(mutex_);
  return lost_;
}

std::shared_ptr<Peer::Stub> Peer::begin(const Context& context) {
  const std::lock_guard lock(mutex_);
  if (lost_) return nullptr;
  calls_.insert(context);
  return stub_;
}

grpc::Status Peer::end(const Context& context, grpc::Status status) {
  const std::lock_guard lock(mutex_);
  calls_.erase(context);
  if (status.ok()) hear();
  if (lost_ && status.error_code() == grpc::StatusCode::CANCELLED) return lost_locked();
  return status;
}

grpc::Status Peer::lost_status() const {
  const std::lock_guard lock(mutex_);
  return lost_locked();
}

grpc::Status Peer::lost_locked() const {
  return {grpc::StatusCode::UNAVAILABLE,
          fmt::format("it has answered none of the last {} pings{}{}", unanswered_,
                      failure_.empty() ? "" : ": ", failure_)};
}

}  // namespace sightline::server::shards

// RayQueryService: batches of rays and of points, streams of batches, prefetches, and segments.
#include "server/queries/cast_rpc.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "server/exec/call_context.h"
#include "server/exec/caller.h"
#include "server/exec/malformed.h"
#include "server/exec/rpc_status.h"
#include "server/queries/cast_job.h"
#include "server/queries/cast_updates.h"
#include "server/queries/prefetch_rpc.h"
#include "server/queries/segment_rpc.h"
#include "server/scenes/revision_pins.h"
#include "server/scenes/revision_wait.h"

namespace sightline::server::queries {
namespace {

void log_if_slow(const char* method, const grpc::ServerContextBase& context, const CastJob& job,
                 std::chrono::milliseconds limit) {
  if (!job.is_slow(limit)) return;
  spdlog::warn("event=slow_query method={}{} {}", method, exec::call_ids_of(context),
               job.slow_description());
}

/// The messages of casts.
struct OfRays {
  using Request = v1::CastRaysRequest;
  using Reply = v1::CastRaysResponse;
  using StreamRequest = v1::StreamCastRaysRequest;
  using StreamReply = v1::StreamCastRaysResponse;
  static constexpr const char *kCall = "CastRays", *kStream = "StreamCastRays";
};

/// The messages of queries of points.
struct OfPoints {
  using Request = v1::QueryPointsRequest;
  using Reply = v1::QueryPointsResponse;
  using StreamRequest = v1::StreamQueryPointsRequest;
  using StreamReply = v1::StreamQueryPointsResponse;
  static constexpr const char *kCall = "QueryPoints", *kStream = "StreamQueryPoints";
};

/// Where a CastJob makes a reply: in a call's own message, or one that becomes it.
template <class Reply>
class MadeReply {
 public:
  /// The message to make, with the memory of the reply before.
  v1::CastRaysResponse& begin(v1::QueryPointsResponse& reply) {
    made_.mutable_columns()->Swap(reply.mutable_columns());
    return made_;
  }
  void end(v1::QueryPointsResponse& reply) {
    reply.mutable_columns()->Swap(made_.mutable_columns());
    reply.mutable_names()->Swap(made_.mutable_names());
    reply.mutable_unanswered()->swap(*made_.mutable_unanswered());
    *reply.mutable_served() = made_.served();
    reply.set_first_point(made_.first_ray());
    reply.set_more(made_.more());
    reply.clear_stats();
    if (made_.has_stats()) *reply.mutable_stats() = made_.stats();
  }

 private:
  v1::CastRaysResponse made_;
};

template <>
class MadeReply<v1::CastRaysResponse> {
 public:
  v1::CastRaysResponse& begin(v1::CastRaysResponse& reply) { return reply; }
  void end(v1::CastRaysResponse&) {}
};

/// When a read began that asks for a revision or a later one; nothing for other reads.
using ReadBegin = std::optional<std::chrono::steady_clock::time_point>;

template <class Request>
ReadBegin begin_of_read(const Request& request) {
  if (request.consistency().requirement_case() != v1::Consistency::kAtLeast) return std::nullopt;
  return std::chrono::steady_clock::now();
}

void count_read(metrics::QueryMetrics& metrics, const ReadBegin& begin) {
  if (begin) metrics.count_revision_wait(std::chrono::steady_clock::now() - *begin);
}

/// Lives until its task has called Finish(), also if the client has cancelled the call.
template <class Messages>
class CastCall final : public grpc::ServerUnaryReactor {
 public:
  CastCall(const scenes::Services& services, grpc::CallbackServerContext& context,
           const typename Messages::Request& request, typename Messages::Reply& reply)
      : services_(services),
        context_(context),
        unread_(services.unread),
        metrics_(services.metrics),
        slow_(services.slow_query),
        job_(services, context, Replies::kOne),
        wait_(std::make_shared<scenes::RevisionWait>(services.compute, services.admission,
                                                     services.waiting_reads)),
        request_(request),
        reply_(reply) {}

  void start() {
    reply_.clear_applied();  // a reply before may have left it
    if (request_.has_apply()) return start_with_updates();
    if (const Status opened = exec::to_status([&] { return job_.open(request_); }); !opened)
      return end(opened);
    wait_->read(job_.scene(), request_.consistency(), context_.deadline(), request_.ByteSizeLong(),
                job_.caller(),
                [this, begin = begin_of_read(request_)](
                    Result<scenes::RevisionWait::SnapshotPointer> pinned) {
                  count_read(metrics_, begin);
                  if (!pinned) return end(pinned.error());
                  job_.pin(std::move(*pinned));
                  cast();
                });
  }

  void OnCancel() override {
    job_.cancel();
    wait_->cancel();
    if (updates_) updates_->cancel();
  }
  void OnDone() override { delete this; }

 private:
  void cast() {
    if (const Status accepted = exec::to_status([&] { return job_.accept(request_); }); !accepted)
      return end(accepted);
    answer();
  }

  void answer() {
    job_.enqueue(made_.begin(reply_), [this](const Status& done) { answered(done); });
  }

  void answered(const Status& status) {
    log_if_slow(Messages::kCall, context_, job_, slow_);
    job_.close();
    made_.end(reply_);
    end(status);
  }

  /// Whatever of the rays can be refused is refused before anything is applied.
  void start_with_updates() {
    const Status ready = exec::to_status([this] {
      if (Status good = check_updates(request_); !good) return good;
      if (Status opened = job_.open(request_); !opened) return opened;
      updates_.emplace(services_, context_, request_.scene(), request_.apply(),
                       *reply_.mutable_applied());
      if (Status accepted = job_.accept(request_); !accepted) return accepted;
      if (Status admitted = updates_->admit(); !admitted) return admitted;
      if (job_.scene()->loaded() && updates_->are_few()) {
        services_.compute.enqueue_small(exec::flow_of(job_.caller(), request_.scene()),
                                        [this] { return apply_and_cast(); });
      } else {
        updates_->enqueue([this](CastUpdates::Outcome applied) {
          if (pin(std::move(applied))) answer();
        });
      }
      return Status();
    });
    if (!ready) end_without_cast(ready);
  }

  /// The slices of a job on a worker for small casts: the updates have one, then the rays. Returns
  /// whether there are more; if not, this may be gone.
  bool apply_and_cast() {
    if (making_ == nullptr) {
      auto applied = updates_->run([this](CastUpdates::Outcome later) {
        if (pin(std::move(later))) answer();
      });
      if (!applied || !pin(*std::move(applied))) return false;
      making_ = &made_.begin(reply_);
      return true;
    }
    return job_.run_slice_here(*making_, [this](const Status& done) { answered(done); });
  }

  /// Ends the call if there is no revision; then this may be gone.
  bool pin(CastUpdates::Outcome applied) {
    if (!applied) {
      end_without_cast(applied.error());
      return false;
    }
    job_.pin(std::move(applied->scene), std::move(applied->snapshot));
    return true;
  }

  void end_without_cast(const Status& status) {
    job_.drop_batch();
    job_.close();
    end(status);
  }

  void end(const Status& status) {
    const grpc::Status answer = exec::to_grpc(
        exec::hold_reply(unread_, context_, job_.caller(), request_, reply_, status, held_));
    exec::log_rpc(Messages::kCall, context_, answer, begun_, [this] { return job_.description(); });
    Finish(answer);  // may delete this reactor
  }

  const exec::LogClock::time_point begun_ = exec::LogClock::now();
  const scenes::Services& services_;
  grpc::CallbackServerContext& context_;
  exec::UnreadReplies& unread_;
  metrics::QueryMetrics& metrics_;
  const std::chrono::milliseconds slow_;
  CastJob job_;
  const std::shared_ptr<scenes::RevisionWait> wait_;
  const typename Messages::Request& request_;
  typename Messages::Reply& reply_;
  std::optional<CastUpdates> updates_;  // if the request has some
  MadeReply<typename Messages::Reply> made_;
  v1::CastRaysResponse* making_ = nullptr;  // while apply_and_cast() answers
  std::unique_ptr<exec::UnreadReplies::Held> held_;
};

/// What a stream waits for while nothing is in work.
enum class Wait : std::uint8_t { kNone, kForRequest, kForWrite };

/// Reads a batch, traces it, writes its replies, and only then reads again. At most one operation
/// is under way, so the call needs two messages, and a client that does not read its replies is not
/// served.
template <class Messages>
class CastStream final : public grpc::ServerBidiReactor<typename Messages::StreamRequest,
                                                        typename Messages::StreamReply> {
 public:
  CastStream(const scenes::Services& services, grpc::CallbackServerContext& context)
      : compute_(services.compute),
        unread_(services.unread),
        metrics_(services.metrics),
        slow_(services.slow_query),
        context_(context),
        streams_(services.cast_streams),
        pins_(services.pins),
        job_(services, context, Replies::kMany),
        wait_(std::make_shared<scenes::RevisionWait>(services.compute, services.admission,
                                                     services.waiting_reads)) {}

  void start() {
    const Status entered =
        streams_.enter(this, job_.caller(), {.on_late = [this] { end_idle(); }}, &idle_);
    if (!entered) return end(entered);
    read();
  }

  void OnReadDone(bool ok) override {
    idle_.end();
    rest_.end();
    if (!stop_waiting()) return;  // end_idle() or let_go() was first
    if (!ok) return end(exec::end_of_reads(request_));
    if (const Status good = check_no_updates(request_.request()); !good) {
      request_ = {};  // a refusal may wait: see RefusalPace
      return end(good);
    }
    if (batches_++ > 0) return cast();
    const typename Messages::Request& first = request_.request();
    const Status opened = exec::to_status([&] {
      const Status allowed = exec::check_role(context_, exec::Role::kRead, first.scene());
      return allowed ? job_.open(first) : allowed;
    });
    if (!opened) return end(opened);
    wait_->read(
        job_.scene(), first.consistency(), context_.deadline(), first.ByteSizeLong(), job_.caller(),
        [this, begin = begin_of_read(first)](Result<scenes::RevisionWait::SnapshotPointer> pinned) {
          count_read(metrics_, begin);
          if (!pinned) return end(pinned.error());
          pins_.enter(this, {.caller = job_.caller(),
                             .scene = job_.scene(),
                             .revision = *pinned,
                             .rest = &rest_,
                             .let_go = [this](const Error& error) { return let_go(error); }});
          job_.pin(std::move(*pinned));
          cast();
        });
  }

  void OnWriteDone(bool ok) override {
    held_.reset();
    rest_.end();
    const bool let_go = !stop_waiting() && !reply_.response().more();
    if (let_go) return end(*let_go_with_);
    if (!ok) return end(Error{Code::kCancelled, "the reply could not be written", "CANCELLED"});
    if (reply_.response().more()) return answer();
    read();
  }

  void OnCancel() override {
    job_.cancel();
    wait_->cancel();
  }

  void OnDone() override {
    held_.reset();  // before the context goes
    pins_.leave(this);
    streams_.leave(this);
    // On a worker: this may hold the last reference to a revision and free its trees.
    compute_.enqueue_background([this] { delete this; });
  }

 private:
  void read() {
    exec::free_if_large(reply_);
    job_.rest();
    const std::lock_guard lock(mutex_);
    idle_.begin(exec::kIdleStream);
    rest_.begin(exec::kIdleStream);
    exec::before_read(request_);
    waits_ = Wait::kForRequest;
    this->StartRead(&request_);
  }

  /// Whether the call was waiting for its peer. Who stops the wait for a request may end the call.
  bool stop_waiting() {
    const std::lock_guard lock(mutex_);
    return std::exchange(waits_, Wait::kNone) != Wait::kNone;
  }

  /// The client has sent nothing for too long.
  void end_idle() {
    {
      const std::lock_guard lock(mutex_);
      if (waits_ != Wait::kForRequest) return;
      waits_ = Wait::kNone;
    }
    end(Error{Code::kAborted,
              "the stream was idle, and its place is needed or its time is over: open it again",
              "STREAM_IDLE"});
  }

  /// Gives the revision away, if nothing is in work: its memory is needed elsewhere. While the last
  /// reply to a batch is written, the call ends later.
  scenes::RevisionPins::SnapshotPointer let_go(const Error& error) {
    Wait waited = Wait::kNone;
    {
      const std::lock_guard lock(mutex_);
      waited = std::exchange(waits_, Wait::kNone);
      if (waited == Wait::kForWrite) let_go_with_ = error;
    }
    if (waited == Wait::kNone) return nullptr;
    auto revision = job_.let_go();
    if (waited == Wait::kForRequest) end(error);
    return revision;
  }

  void cast() {
    if (const Status accepted = exec::to_status([this] { return job_.accept(request_.request()); });
        !accepted) {
      request_ = {};  // a refusal may wait: see RefusalPace
      return end(accepted);
    }
    answer();
  }

  void answer() {
    job_.enqueue(made_.begin(*reply_.mutable_response()), [this](const Status& done) {
      log_if_slow(Messages::kStream, context_, job_, slow_);
      made_.end(*reply_.mutable_response());
      const Status held =
          exec::hold_reply(unread_, context_, job_.caller(), request_, reply_, done, held_);
      if (!held) return end(held);
      reply_.set_chunk(request_.chunk());
      if (reply_.response().more()) return this->StartWrite(&reply_);
      const std::lock_guard lock(mutex_);
      rest_.begin(exec::kReplyTimeout);
      waits_ = Wait::kForWrite;
      this->StartWrite(&reply_);
    });
  }

  void end(const Status& status) {
    const grpc::Status answer = exec::to_grpc(status);
    exec::log_rpc(Messages::kStream, context_, answer, begun_,
                  [this] { return fmt::format("batches={} {}", batches_, job_.description()); });
    this->Finish(answer);
  }

  const exec::LogClock::time_point begun_ = exec::LogClock::now();
  exec::Compute& compute_;
  exec::UnreadReplies& unread_;
  metrics::QueryMetrics& metrics_;
  const std::chrono::milliseconds slow_;
  grpc::CallbackServerContext& context_;
  exec::CallRegistry& streams_;
  scenes::RevisionPins& pins_;
  exec::PeerWait idle_;
  exec::PeerWait rest_;  // nothing is in work
  std::mutex mutex_;     // held while an operation starts, and protects the next two
  Wait waits_ = Wait::kNone;
  std::optional<Error> let_go_with_;  // during the last write
  CastJob job_;
  const std::shared_ptr<scenes::RevisionWait> wait_;
  std::uint64_t batches_ = 0;
  typename Messages::StreamRequest request_;
  typename Messages::StreamReply reply_;
  MadeReply<typename Messages::Reply> made_;
  std::unique_ptr<exec::UnreadReplies::Held> held_;  // while reply_ is written
};

}  // namespace

RayQueryRpc::RayQueryRpc(const scenes::Services& services) : services_(services) {
  SetMessageAllocatorFor_CastRays(&messages_);
  SetMessageAllocatorFor_QueryPoints(&point_messages_);
}

grpc::ServerUnaryReactor* RayQueryRpc::CastRays(grpc::CallbackServerContext* context,
                                                const v1::CastRaysRequest* request,
                                                v1::CastRaysResponse* reply) {
  auto* reactor = new CastCall<OfRays>(services_, *context, *request, *reply);
  reactor->start();
  return reactor;
}

grpc::ServerBidiReactor<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse>*
RayQueryRpc::StreamCastRays(grpc::CallbackServerContext* context) {
  auto* stream = new CastStream<OfRays>(services_, *context);
  stream->start();
  return stream;
}

grpc::ServerUnaryReactor* RayQueryRpc::QueryPoints(grpc::CallbackServerContext* context,
                                                   const v1::QueryPointsRequest* request,
                                                   v1::QueryPointsResponse* reply) {
  auto* reactor = new CastCall<OfPoints>(services_, *context, *request, *reply);
  reactor->start();
  return reactor;
}

grpc::ServerBidiReactor<v1::StreamQueryPointsRequest, v1::StreamQueryPointsResponse>*
RayQueryRpc::StreamQueryPoints(grpc::CallbackServerContext* context) {
  auto* stream = new CastStream<OfPoints>(services_, *context);
  stream->start();
  return stream;
}

grpc::ServerWriteReactor<v1::PrefetchResponse>* RayQueryRpc::Prefetch(
    grpc::CallbackServerContext* context, const v1::PrefetchRequest* request) {
  return start_prefetch(services_, *context, *request);
}

grpc::ServerWriteReactor<v1::OpenSegmentResponse>* RayQueryRpc::OpenSegment(
    grpc::CallbackServerContext* context, const v1::OpenSegmentRequest* request) {
  return start_segment(services_, *context, *request);
}

}  // namespace sightline::server::queries

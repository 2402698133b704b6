// RayQueryService.StreamCastRays: many batches over one call, one at a time.
#include "server/queries/stream_cast_rpc.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "server/exec/guarded.h"
#include "server/exec/rpc_log.h"
#include "server/exec/rpc_status.h"

namespace sightline::server::queries {
namespace {

/// Read, trace, write, and only then read again, or go on with what is left of the batch: at most
/// one operation is under way, so a client that does not read its replies is not served, and the
/// two messages are enough for the whole call.
class CastStream final
    : public grpc::ServerBidiReactor<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse> {
 public:
  CastStream(const CastServices& services, const grpc::CallbackServerContext& context,
             std::atomic<std::size_t>& open)
      : compute_(services.compute),
        context_(context),
        open_(open),
        job_(services, Replies::kMany),
        wait_(std::make_shared<scenes::RevisionWait>(services.waiting)) {}

  void start(std::size_t limit) {
    const std::size_t before = open_.fetch_add(1);
    if (before >= limit) {
      return end(Error{
          Code::kResourceExhausted,
          fmt::format("{} streams of rays are open, the limit is {}; retry later", before, limit),
          "TOO_MANY_STREAMS"});
    }
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    if (!ok) return end({});  // the client has closed its side, or is gone
    if (batches_++ > 0) return cast();
    const v1::CastRaysRequest& first = request_.request();
    if (const Status opened = exec::to_status([&] { return job_.open(first); }); !opened)
      return end(opened);
    wait_->read(job_.scene(), first.consistency(), context_.deadline(), first.ByteSizeLong(),
                [this](Result<scenes::RevisionWait::SnapshotPointer> pinned) {
                  if (!pinned) return end(pinned.error());
                  job_.pin(std::move(*pinned));
                  cast();
                });
  }

  void OnWriteDone(bool ok) override {
    if (!ok) return end(Error{Code::kCancelled, "the reply could not be written", "CANCELLED"});
    if (reply_.response().more()) return compute_.enqueue([this] { answer(); });
    StartRead(&request_);
  }

  void OnCancel() override {
    job_.cancel();
    wait_->cancel();
  }

  void OnDone() override {
    open_.fetch_sub(1);
    // In the arena, as it may be the last to hold a revision with all its trees.
    compute_.enqueue([this] { delete this; });
  }

 private:
  void cast() {
    if (const Status accepted =
            exec::to_status([this] { return job_.accept(request_.request().rays()); });
        !accepted)
      return end(accepted);
    compute_.enqueue([this] { answer(); });
  }

  void answer() {
    const Status done = exec::to_status([this] { return job_.run(*reply_.mutable_response()); });
    if (!done) return end(done);
    reply_.set_chunk(request_.chunk());
    StartWrite(&reply_);
  }

  void end(const Status& status) {
    const grpc::Status answer = exec::to_grpc(status);
    exec::log_rpc("StreamCastRays", answer, begun_, fmt::format("batches={}", batches_));
    Finish(answer);
  }

  const exec::LogClock::time_point begun_ = exec::LogClock::now();
  exec::Compute& compute_;
  const grpc::CallbackServerContext& context_;
  std::atomic<std::size_t>& open_;
  CastJob job_;
  const std::shared_ptr<scenes::RevisionWait> wait_;
  std::uint64_t batches_ = 0;
  v1::StreamCastRaysRequest request_;
  v1::StreamCastRaysResponse reply_;
};

}  // namespace

grpc::ServerBidiReactor<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse>* start_cast_stream(
    const CastServices& services, const grpc::CallbackServerContext& context,
    std::atomic<std::size_t>& open, std::size_t limit) {
  auto* stream = new CastStream(services, context, open);
  stream->start(limit);
  return stream;
}

}  // namespace sightline::server::queries

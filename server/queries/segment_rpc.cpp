// RayQueryService.OpenSegment: a call that is open as long as its segment.
#include "server/queries/segment_rpc.h"

#include <fmt/format.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "server/exec/caller.h"
#include "server/exec/rpc_status.h"
#include "server/segments/segments.h"

namespace sightline::server::queries {
namespace {

/// Two activities run, one after the other: making the segment, and writing the response. Then the
/// call waits for its end.
class SegmentCall final : public grpc::ServerWriteReactor<v1::OpenSegmentResponse> {
 public:
  SegmentCall(const scenes::Services& services, grpc::CallbackServerContext& context,
              std::uint64_t bytes)
      : services_(services),
        segments_(services.segments),
        context_(context),
        caller_(exec::caller_of(context)),
        bytes_(bytes) {}

  void start() {
    const Status entered = exec::to_status([this] {
      if (Status offered = segments_.check_offered(context_.peer()); !offered) return offered;
      return segments_.calls().enter(this, caller_, {.on_stop = [this] {
                                       advance([this] { end(segments_.calls().stopped_error()); });
                                     }});
    });
    if (!entered)
      return advance([&] {
        opening_ = false;
        end(entered);
      });
    services_.compute.enqueue_work(caller_, [this] { open(); });
  }

  void OnWriteDone(bool ok) override {
    held_.reset();
    advance([&] {
      writing_ = false;
      if (!ok) end(Error{Code::kCancelled, "the response could not be written", "CANCELLED"});
    });
  }

  void OnCancel() override {
    advance([this] { end(Error{Code::kCancelled, "the call was cancelled", "CANCELLED"}); });
  }

  void OnDone() override {
    held_.reset();  // before the context goes
    // On a worker: to give the pages back takes a while.
    services_.compute.enqueue_work(caller_, [this] {
      segments_.close(response_.segment());
      segments_.calls().leave(this);
      delete this;
    });
  }

 private:
  /// Runs on a worker.
  void open() {
    const Status opened = exec::to_status([&]() -> Status {
      if (has_ended()) return {};  // nothing is made for a call that is gone
      auto made = segments_.open(caller_, bytes_);
      if (!made) return made.error();
      response_.set_segment(made->name);
      response_.set_bytes(made->segment->size());
      response_.set_socket(segments_.socket());
      response_.set_key(made->key.data(), made->key.size());
      auto unread = services_.unread.hold(context_, caller_, response_.ByteSizeLong());
      if (!unread) return unread.error();
      held_ = std::move(*unread);
      return {};
    });
    advance([&] {
      opening_ = false;
      if (!opened) end(opened);
      if (ending_) return;
      writing_ = true;
      StartWrite(&response_);
    });
  }

  bool has_ended() {
    const std::lock_guard lock(mutex_);
    return ending_.has_value();
  }

  /// Call it with the mutex held.
  void end(const Status& status) {
    if (!ending_) ending_ = status;
  }

  /// Makes the change, and ends the call if it is to end and no activity runs. The call may be
  /// deleted before this returns.
  template <class Change>
  void advance(const Change& change) {
    grpc::Status status;
    {
      const std::lock_guard lock(mutex_);
      change();
      if (opening_ || writing_ || !ending_ || ended_) return;
      ended_ = true;
      status = exec::to_grpc(*ending_);
    }
    exec::log_rpc("OpenSegment", context_, status, begun_,
                  [this] { return fmt::format("peer={} bytes={}", caller_.connection, bytes_); });
    Finish(status);
  }

  const exec::LogClock::time_point begun_ = exec::LogClock::now();
  const scenes::Services& services_;
  segments::Segments& segments_;
  grpc::CallbackServerContext& context_;
  const exec::Caller caller_;
  const std::uint64_t bytes_;
  v1::OpenSegmentResponse response_;                 // not changed after open()
  std::unique_ptr<exec::UnreadReplies::Held> held_;  // until response_ is written

  std::mutex mutex_;  // protects all members below
  bool opening_ = true, writing_ = false;
  std::optional<Status> ending_;
  bool ended_ = false;
};

}  // namespace

grpc::ServerWriteReactor<v1::OpenSegmentResponse>* start_segment(
    const scenes::Services& services, grpc::CallbackServerContext& context,
    const v1::OpenSegmentRequest& request) {
  auto* call = new SegmentCall(services, context, request.bytes());
  call->start();
  return call;
}

}  // namespace sightline::server::queries

// SceneService.WatchScene: every revision of a scene as it is made.
#include "server/updates/watch_rpc.h"

#include <fmt/format.h>
#include <grpcpp/alarm.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>

#include "server/codec/update_parts.h"
#include "server/exec/rpc_status.h"
#include "server/scenes/stored_scene.h"

namespace sightline::server::updates {
namespace {

/// Reads a scene's log as messages of limited size, and shares its entries. Threads: one at a time.
class WatchCursor {
 public:
  /// Starts after `revision`. `scene` outlives this.
  WatchCursor(const scenes::StoredScene& scene, std::uint64_t revision)
      : scene_(scene), reached_(revision) {}

  /// The last revision whose messages are complete.
  std::uint64_t reached() const { return reached_; }
  /// Whether the log has a newer revision.
  bool behind() const { return reached_ < scene_.log().last(); }

  /// The next message, if behind(). Errors: kOutOfRange, if the log no longer has the revision.
  Status next(v1::WatchSceneResponse& out) {
    out.Clear();
    if (!begun_) {
      auto found = scene_.log().find(reached_ + 1);
      if (!found) return found.error();
      record_ = std::move(*found);
      parts_ = record_.bytes();
      begun_ = true;
    }
    if (!parts_.empty()) codec::take_part(parts_, out);
    encode_revision(scene_.token(reached_ + 1), *out.mutable_revision());
    out.set_more(!parts_.empty());
    if (out.more()) return {};
    record_ = {};
    begun_ = false;
    ++reached_;
    return {};
  }

  /// A message with reached() and no updates.
  void progress(v1::WatchSceneResponse& out) const {
    out.Clear();
    encode_revision(scene_.token(reached_), *out.mutable_revision());
    out.set_progress(true);
  }

 private:
  const scenes::StoredScene& scene_;
  std::uint64_t reached_;
  bool begun_ = false;      // with the revision after reached_
  scenes::Record record_;   // that revision's record
  std::string_view parts_;  // parts of it that are not sent yet
};

/// Encodes a message on a worker, writes it, and only then encodes the next. The call holds one
/// message: a client that does not read falls behind in the log and costs no memory.
class Watch final : public grpc::ServerWriteReactor<v1::WatchSceneResponse> {
 public:
  Watch(const scenes::Services& services, grpc::CallbackServerContext& context)
      : services_(services), context_(context), caller_(exec::caller_of(context)) {}

  /// `request` lives as long as the call.
  void start(const v1::WatchSceneRequest& request) {
    services_.compute.enqueue_update(exec::flow_of(caller_, request.scene()),
                                     [this, &request] { begin(request); });
  }

  void begin(const v1::WatchSceneRequest& request) {
    const Status ready = exec::to_status([&] { return open(request); });
    advance([&] {
      starting_ = false;
      if (!ready) end(ready);
      if (!ending_) set_clock();
    });
  }

  void OnWriteDone(bool ok) override {
    advance([&] {
      writing_ = false;
      held_.reset();
      if (!ok) end(Error{Code::kCancelled, "the message could not be written", "CANCELLED"});
    });
  }

  void OnCancel() override {
    advance([this] { end(Error{Code::kCancelled, "the call was cancelled", "CANCELLED"}); });
  }

  void OnDone() override {
    services_.compute.enqueue_background([this] {
      services_.watches.leave(this);
      if (listener_ != 0) scene_->events().unsubscribe(listener_);
      delete this;
    });
  }

 private:
  Status open(const v1::WatchSceneRequest& request) {
    auto scene = services_.find_loaded(request.scene());
    if (!scene) return scene.error();
    scene_ = std::move(*scene);
    const std::uint64_t head = scene_->snapshot()->revision();
    const std::uint64_t from = request.has_start_revision() ? request.start_revision() : head;
    if (from > head) {
      return Error{Code::kOutOfRange,
                   fmt::format("revision {} is not there yet, the newest is {}", from, head),
                   "REVISION_NOT_KEPT"};
    }
    cursor_.emplace(*scene_, from);
    if (Status entered = services_.watches.enter(
            this, caller_,
            {.on_stop = [this] { advance([this] { end(services_.watches.stopped_error()); }); }});
        !entered)
      return entered;
    listener_ = scene_->events().subscribe([this] { on_scene_event(); });
    if (scene_->removed()) return scene_->removed_error();
    return {};
  }

  void on_scene_event() {
    advance([this] {
      if (scene_->removed()) end(scene_->removed_error());
    });
  }

  /// Runs on a worker.
  void encode() {
    const Status encoded = exec::to_status([this]() -> Status {
      if (std::exchange(first_sent_, true) && cursor_->behind()) return cursor_->next(message_);
      cursor_->progress(message_);
      return {};
    });
    advance([&] {
      working_ = false;
      if (!encoded) end(encoded);
      if (ending_) return;
      auto held = services_.unread.hold(context_, caller_, 2 * message_.ByteSizeLong());
      if (!held) return end(held.error());
      held_ = std::move(*held);
      reported_ = true;
      progress_due_ = false;
      writing_ = true;
      StartWrite(&message_);
    });
  }

  // The members below are called with the mutex held.

  void end(const Status& status) {
    if (ending_) return;
    ending_ = status;
    if (ticking_) clock_.Cancel();
  }

  void set_clock() {
    ticking_ = true;
    clock_.Set(std::chrono::system_clock::now() + kWatchProgress / 2, [this](bool rang) {
      advance([&] {
        ticking_ = false;
        if (!rang || ending_) return;
        progress_due_ = !std::exchange(reported_, false);
        set_clock();
      });
    });
  }

  /// Makes the change, then starts what may run, or ends the call. The call may be deleted before
  /// this returns.
  template <class Change>
  void advance(const Change& change) {
    grpc::Status status;
    {
      const std::lock_guard lock(mutex_);
      change();
      if (starting_ || ended_ || working_ || writing_) return;
      if (!ending_) {
        if (!progress_due_ && !cursor_->behind()) return;
        working_ = true;
        return services_.compute.enqueue_update(exec::flow_of(caller_, scene_->info().name),
                                                [this] { encode(); });
      }
      if (ticking_) return;
      ended_ = true;
      status = exec::to_grpc(*ending_);
      exec::log_rpc("WatchScene", context_, status, begun_,
                    fmt::format("revision={}", cursor_ ? cursor_->reached() : 0));
    }
    Finish(status);
  }

  const exec::LogClock::time_point begun_ = exec::LogClock::now();
  const scenes::Services& services_;
  grpc::CallbackServerContext& context_;
  const exec::Caller caller_;
  std::shared_ptr<scenes::StoredScene> scene_;
  std::uint64_t listener_ = 0;
  std::optional<WatchCursor> cursor_;  // this and the next two: used while encoding
  bool first_sent_ = false;
  v1::WatchSceneResponse message_;

  std::mutex mutex_;  // protects all members below
  bool starting_ = true;
  bool working_ = false, writing_ = false, ticking_ = false;  // operations that run
  bool reported_ = false;     // a message was written since the last alarm
  bool progress_due_ = true;  // the first message reports the start
  std::optional<Status> ending_;
  bool ended_ = false;
  std::unique_ptr<exec::UnreadReplies::Held> held_;  // while message_ is written
  grpc::Alarm clock_;
};

}  // namespace

grpc::ServerWriteReactor<v1::WatchSceneResponse>* start_watch(
    const scenes::Services& services, grpc::CallbackServerContext& context,
    const v1::WatchSceneRequest& request) {
  auto* watch = new Watch(services, context);
  watch->start(request);
  return watch;
}

}  // namespace sightline::server::updates

// RayQueryService.Prefetch: one request, and progress until the trees are built.
#include "server/queries/prefetch_rpc.h"

#include <fmt/format.h>
#include <grpcpp/alarm.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "server/exec/caller.h"
#include "server/exec/rpc_status.h"
#include "server/queries/prefetch_job.h"

namespace sightline::server::queries {
namespace {

constexpr std::chrono::milliseconds kBeforeFirstReport{20};
constexpr std::chrono::milliseconds kBetweenReports{250};

/// Three activities run at a time: building, here or at peers, an alarm, and writing a report. Each
/// calls advance() when it stops; the last one to stop ends the call.
class PrefetchCall final : public grpc::ServerWriteReactor<v1::PrefetchResponse> {
 public:
  PrefetchCall(const scenes::Services& services, grpc::CallbackServerContext& context,
               exec::Caller caller, const v1::PrefetchRequest& request)
      : compute_(services.compute),
        context_(context),
        unread_(services.unread),
        calls_(request.has_shard() ? services.shard_prefetches : services.prefetches),
        flow_(exec::flow_of(caller, request.scene())),
        job_(services, context, std::move(caller)) {}

  /// `request` lives as long as the call.
  void start(const v1::PrefetchRequest& request) {
    compute_.enqueue_update(flow_, [this, &request] { begin(request); });
  }

  void begin(const v1::PrefetchRequest& request) {
    const Status ready = exec::to_status([&] {
      if (Status opened = job_.open(request); !opened) return opened;
      return calls_.enter(this, job_.caller(), {.on_stop = [this] { job_.cancel(); }});
    });
    if (!ready) return end(ready);
    const std::lock_guard lock(mutex_);
    set_alarm(kBeforeFirstReport);
    compute_.enqueue_background(flow_, [this] {
      if (job_.is_sharded()) {
        ask();
      } else {
        finish(exec::to_status([this] { return job_.run(); }));
      }
      return false;
    });
  }

  void OnWriteDone(bool) override {
    advance([this] { writing_ = false; });
  }

  void OnCancel() override { job_.cancel(); }

  void OnDone() override {
    held_.reset();  // before the context goes
    compute_.enqueue_background([this] { delete this; });
  }

 private:
  void ask() {
    bool asked = false;
    const auto ask_peers = [&] { return job_.ask([this] { ask_again(); }, asked); };
    Status ran = exec::to_status(ask_peers);
    if (ran && asked) return;  // this may be gone
    finish(std::move(ran));
  }

  void ask_again() {
    const Status pushed = exec::to_status([this] {
      compute_.enqueue_background(flow_, [this] {
        ask();
        return false;
      });
      return Status();
    });
    if (!pushed) finish(pushed);
  }

  void finish(Status built) {
    // The call leaves before the last report is written: a client that has read it may start the
    // next prefetch.
    calls_.leave(this);
    if (!built && calls_.stopped()) built = calls_.stopped_error();
    {
      const std::lock_guard lock(mutex_);
      const Status reported = report_to(last_);
      last_.set_done(true);
      built_ = built ? reported : built;
      reporting_ = false;
    }
    job_.close();
    alarm_.Cancel();
    advance([this] { building_ = false; });
  }

  Status report_to(v1::PrefetchResponse& response) {
    return exec::to_status([&] {
      job_.report(response);
      return Status();
    });
  }

  void set_alarm(std::chrono::milliseconds time) {
    ticking_ = true;
    alarm_.Set(std::chrono::system_clock::now() + time, [this](bool) { tick(); });
  }

  void tick() {
    advance([this] {
      ticking_ = false;
      if (!reporting_) return;
      set_alarm(kBetweenReports);
      // A slow client gets fewer reports.
      if (writing_ || !report_to(report_)) return;
      writing_ = true;
      StartWrite(&report_);
    });
  }

  /// Makes the change, and ends the call if no activity runs. The call may then be deleted before
  /// this returns.
  template <class Change>
  void advance(const Change& change) {
    {
      const std::lock_guard lock(mutex_);
      change();
      if (building_ || ticking_ || writing_ || ended_) return;
      ended_ = true;
    }
    if (!built_) return end(built_);
    // The message is small; holding it bounds the time to read it.
    if (auto held = unread_.hold(context_, job_.caller(), last_.ByteSizeLong())) {
      held_ = std::move(*held);
    } else {
      return end(held.error());
    }
    log(grpc::Status::OK);
    StartWriteAndFinish(&last_, {}, grpc::Status::OK);
  }

  void end(const Status& status) {
    const grpc::Status answer = exec::to_grpc(status);
    log(answer);
    Finish(answer);
  }

  void log(const grpc::Status& answer) const {
    exec::log_rpc("Prefetch", context_, answer, log_begun_, [this] {
      return fmt::format("scene={} peer={} rays={} cells={} trees={} build_us={}", flow_.scene,
                         flow_.connection, last_.rays_total(), last_.cells_expanded(),
                         last_.meshes_done(), last_.build_us());
    });
  }

  const exec::LogClock::time_point log_begun_ = exec::LogClock::now();
  exec::Compute& compute_;
  grpc::CallbackServerContext& context_;
  exec::UnreadReplies& unread_;
  exec::CallRegistry& calls_;
  const exec::FlowKey flow_;
  PrefetchJob job_;
  std::mutex mutex_;                                          // protects all members below
  bool building_ = true, ticking_ = false, writing_ = false;  // activities that run
  bool reporting_ = true, ended_ = false;
  Status built_;
  v1::PrefetchResponse report_, last_;
  grpc::Alarm alarm_;
  std::unique_ptr<exec::UnreadReplies::Held> held_;  // for last_
};

}  // namespace

grpc::ServerWriteReactor<v1::PrefetchResponse>* start_prefetch(const scenes::Services& services,
                                                               grpc::CallbackServerContext& context,
                                                               const v1::PrefetchRequest& request) {
  auto* call = new PrefetchCall(services, context, exec::caller_of(context), request);
  call->start(request);
  return call;
}

}  // namespace sightline::server::queries

// RayQueryService.Prefetch: one request, and progress until the trees are built.
#include "server/queries/prefetch_rpc.h"

#include <fmt/format.h>
#include <grpcpp/alarm.h>

#include <chrono>
#include <mutex>

#include "server/exec/guarded.h"
#include "server/exec/rpc_log.h"
#include "server/exec/rpc_status.h"

namespace sightline::server::queries {
namespace {

constexpr std::chrono::milliseconds kBeforeFirstReport{20};
constexpr std::chrono::milliseconds kBetweenReports{250};

/// Three things go on at a time: the building, a clock that ticks, and the writing of a report.
/// Each calls advance() when it rests; the last one to rest ends the call.
class PrefetchCall final : public grpc::ServerWriteReactor<v1::PrefetchResponse> {
 public:
  PrefetchCall(const CastServices& services, exec::PrefetchCalls& calls)
      : compute_(services.compute), calls_(calls), job_(services) {}

  void start(const v1::PrefetchRequest& request) {
    const Status ready = exec::to_status([&] {
      if (Status opened = job_.open(request); !opened) return opened;
      return calls_.enter(job_);
    });
    if (!ready) return end(ready);
    const std::lock_guard lock(mutex_);
    set_clock(kBeforeFirstReport);
    compute_.enqueue_background([this] { build(); });
  }

  void OnWriteDone(bool) override {
    advance([this] { writing_ = false; });
  }

  void OnCancel() override { job_.cancel(); }

  void OnDone() override {
    compute_.enqueue([this] { delete this; });
  }

 private:
  void build() {
    Status built = exec::to_status([this] { return job_.run(); });
    // Before the last report is read: whoever has read it may ask for the next prefetch.
    if (Status stopped = calls_.leave(job_); !stopped && !built) built = stopped;
    {
      const std::lock_guard lock(mutex_);
      const Status told = report_to(last_);
      last_.set_done(true);
      built_ = built ? told : built;
      reporting_ = false;
    }
    job_.close();
    clock_.Cancel();
    advance([this] { building_ = false; });
  }

  Status report_to(v1::PrefetchResponse& response) {
    return exec::to_status([&] {
      job_.report(response);
      return Status();
    });
  }

  void set_clock(std::chrono::milliseconds time) {
    ticking_ = true;
    clock_.Set(std::chrono::system_clock::now() + time, [this](bool) { tick(); });
  }

  void tick() {
    advance([this] {
      ticking_ = false;
      if (!reporting_) return;
      set_clock(kBetweenReports);
      // A client that is slow to read gets fewer.
      if (writing_ || !report_to(report_)) return;
      writing_ = true;
      StartWrite(&report_);
    });
  }

  /// Ends the call if nothing is under way any more; it may be gone when this returns.
  template <class Change>
  void advance(const Change& change) {
    {
      const std::lock_guard lock(mutex_);
      change();
      if (building_ || ticking_ || writing_ || ended_) return;
      ended_ = true;
    }
    if (!built_) return end(built_);
    log(grpc::Status::OK);
    StartWriteAndFinish(&last_, {}, grpc::Status::OK);
  }

  void end(const Status& status) {
    const grpc::Status answer = exec::to_grpc(status);
    log(answer);
    Finish(answer);
  }

  void log(const grpc::Status& answer) const {
    exec::log_rpc("Prefetch", answer, log_begun_, fmt::format("cells={}", last_.cells_expanded()));
  }

  const exec::LogClock::time_point log_begun_ = exec::LogClock::now();
  exec::Compute& compute_;
  exec::PrefetchCalls& calls_;
  PrefetchJob job_;
  std::mutex mutex_;                                          // of all below
  bool building_ = true, ticking_ = false, writing_ = false;  // under way
  bool reporting_ = true, ended_ = false;
  Status built_;
  v1::PrefetchResponse report_, last_;
  grpc::Alarm clock_;
};

}  // namespace

grpc::ServerWriteReactor<v1::PrefetchResponse>* start_prefetch(const CastServices& services,
                                                               exec::PrefetchCalls& calls,
                                                               const v1::PrefetchRequest& request) {
  auto* call = new PrefetchCall(services, calls);
  call->start(request);
  return call;
}

}  // namespace sightline::server::queries

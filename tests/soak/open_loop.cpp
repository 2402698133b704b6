// Calls that are sent when they are due.
#include "tests/soak/open_loop.h"

#include <grpcpp/client_context.h>

#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "tests/server/support/live_server.h"

namespace sightline::tests::soak {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point then) {
  return std::chrono::duration<double, std::milli>(Clock::now() - then).count();
}

}  // namespace

struct OpenLoop::Tally {
  std::mutex mutex;
  std::condition_variable changed;
  std::size_t open = 0;
  Outcome outcome;
};

/// One call, which deletes itself when it has ended.
struct OpenLoop::Call {
  Tally& tally;
  Clock::time_point due, sent;
  grpc::ClientContext context = {};
  v1::CastRaysResponse reply = {};

  void ended(const grpc::Status& status) {
    const std::lock_guard lock(tally.mutex);
    if (status.ok()) {
      tally.outcome.answered_ms.push_back(ms_since(due));
    } else if (status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED) {
      tally.outcome.refused_ms.push_back(ms_since(sent));
    } else {
      tally.outcome.failed.push_back(status.error_message());
    }
    --tally.open;
    tally.changed.notify_all();
  }
};

OpenLoop::OpenLoop(int port, int connections, v1::CastRaysRequest request, std::string token)
    : request_(std::move(request)), token_(std::move(token)) {
  for (int i = 0; i < connections; ++i)
    stubs_.push_back(v1::RayQueryService::NewStub(connect(port)));
}

OpenLoop::~OpenLoop() = default;

Outcome OpenLoop::run(double rate, std::chrono::duration<double> time) {
  Tally tally;
  const Clock::time_point begin = Clock::now();
  const auto count = static_cast<std::size_t>(rate * time.count());
  for (std::size_t i = 0; i < count; ++i) {
    const std::chrono::duration<double> after(static_cast<double>(i) / rate);
    const auto due = begin + std::chrono::duration_cast<Clock::duration>(after);
    std::this_thread::sleep_until(due);
    {
      const std::lock_guard lock(tally.mutex);
      ++tally.open;
    }
    auto* const call = new Call{tally, due, Clock::now()};
    if (!token_.empty()) call->context.AddMetadata("authorization", "Bearer " + token_);
    stubs_[i % stubs_.size()]->async()->CastRays(&call->context, &request_, &call->reply,
                                                 [call](const grpc::Status& status) {
                                                   call->ended(status);
                                                   delete call;
                                                 });
  }
  std::this_thread::sleep_until(begin + std::chrono::duration_cast<Clock::duration>(time));
  std::unique_lock lock(tally.mutex);
  tally.outcome.seconds = ms_since(begin) / 1000;
  tally.outcome.in_time = tally.outcome.answered_ms.size();
  tally.changed.wait(lock, [&] { return tally.open == 0; });
  return std::move(tally.outcome);
}

}  // namespace sightline::tests::soak

// Refusals at a pace: a client that comes back at once does not keep the server busy with refusing.
#include "server/exec/refusal_pace.h"

#include <grpcpp/alarm.h>
#include <grpcpp/server_context.h>

#include <algorithm>

#include "server/exec/caller.h"
#include "server/exec/rpc_status.h"

namespace sightline::server::exec {
namespace {

namespace experimental = grpc::experimental;
using experimental::InterceptionHookPoints;

constexpr std::size_t kForgetAt = 64;

class PacedCall final : public experimental::Interceptor, RefusalPace::Waiting {
 public:
  PacedCall(RefusalPace& pace, grpc::CallbackServerContext& context, bool unary)
      : pace_(pace), context_(context), unary_(unary) {}
  ~PacedCall() override { pace_.leave(*this); }

  void Intercept(experimental::InterceptorBatchMethods* batch) override {
    if (batch->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_CLOSE)) answer();
    if (batch->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS) &&
        asks_to_retry(batch->GetSendStatus()) && waits(*batch))
      return;
    batch->Proceed();
  }

 private:
  /// The call is over, or the server stops.
  void answer() override {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
    if (is_set_) alarm_.Cancel();
  }

  bool waits(experimental::InterceptorBatchMethods& batch) {
    grpc::RpcAllocatorState* message = unary_ ? context_.GetRpcAllocatorState() : nullptr;
    if (unary_ && message == nullptr) return false;
    const auto now = RefusalPace::Clock::now();
    const auto wait = pace_.due(caller_of(context_).connection, now) - now;
    if (wait <= wait.zero() || !pace_.enter(*this)) return false;
    if (message != nullptr) message->FreeRequest();
    const std::lock_guard lock(mutex_);
    if (is_over_) return false;
    alarm_.Set(std::chrono::system_clock::now() +
                   std::chrono::ceil<std::chrono::system_clock::duration>(wait),
               [this, &batch](bool) {
                 // waits() has returned when the call goes on, which may destroy this.
                 { const std::lock_guard set(mutex_); }
                 batch.Proceed();
               });
    is_set_ = true;
    return true;
  }

  RefusalPace& pace_;
  grpc::CallbackServerContext& context_;
  const bool unary_;
  std::mutex mutex_;
  bool is_set_ = false, is_over_ = false;
  grpc::Alarm alarm_;
};

class PacedCalls final : public experimental::ServerInterceptorFactoryInterface {
 public:
  explicit PacedCalls(RefusalPace& pace) : pace_(pace) {}

  /// All calls of this server are callback calls.
  experimental::Interceptor* CreateServerInterceptor(experimental::ServerRpcInfo* call) override {
    auto* context = dynamic_cast<grpc::CallbackServerContext*>(call->server_context());
    if (context == nullptr) return nullptr;
    return new PacedCall(pace_, *context, call->type() == experimental::ServerRpcInfo::Type::UNARY);
  }

 private:
  RefusalPace& pace_;
};

}  // namespace

RefusalPace::RefusalPace(int burst)
    : interval_(Clock::duration(kRetryDelay) / burst), forget_at_(kForgetAt) {}

RefusalPace::Clock::time_point RefusalPace::due(const std::string& connection,
                                                Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  if (paid_until_.size() >= forget_at_) forget_idle(now);
  Clock::time_point& paid_until = paid_until_[connection];
  // It is at most two delays from now: calls that are cancelled do not count for ever.
  paid_until = std::min(std::max(paid_until, now) + interval_, now + 2 * kRetryDelay);
  return std::max(now, paid_until - kRetryDelay);
}

void RefusalPace::forget_idle(Clock::time_point now) {
  std::erase_if(paid_until_, [now](const auto& entry) { return entry.second <= now; });
  forget_at_ = std::max(kForgetAt, 2 * paid_until_.size());
}

std::size_t RefusalPace::connections() const {
  const std::lock_guard lock(mutex_);
  return paid_until_.size();
}

bool RefusalPace::enter(Waiting& refusal) {
  const std::lock_guard lock(mutex_);
  if (stopped_) return false;
  waiting_.insert(&refusal);
  return true;
}

void RefusalPace::leave(Waiting& refusal) {
  const std::lock_guard lock(mutex_);
  waiting_.erase(&refusal);
}

void RefusalPace::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  for (Waiting* refusal : waiting_) refusal->answer();
}

std::unique_ptr<experimental::ServerInterceptorFactoryInterface> pace_refusals(RefusalPace& pace) {
  return std::make_unique<PacedCalls>(pace);
}

}  // namespace sightline::server::exec

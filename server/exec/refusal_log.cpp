// A line of the log for calls that are refused.
#include "server/exec/refusal_log.h"

#include <grpcpp/server_context.h>
#include <spdlog/spdlog.h>

#include <string>
#include <string_view>
#include <utility>

#include "proto/printable.h"
#include "server/exec/rpc_status.h"

namespace sightline::server::exec {
namespace {

namespace interception = grpc::experimental;

bool is_refusal(grpc::StatusCode code) {
  return code == grpc::StatusCode::RESOURCE_EXHAUSTED ||
         code == grpc::StatusCode::UNAUTHENTICATED || code == grpc::StatusCode::PERMISSION_DENIED;
}

class LoggedRefusal final : public interception::Interceptor {
 public:
  LoggedRefusal(RefusalLog& log, interception::ServerRpcInfo& call) : log_(log), call_(call) {}

  void Intercept(interception::InterceptorBatchMethods* batch) override {
    if (batch->QueryInterceptionHookPoint(interception::InterceptionHookPoints::PRE_SEND_STATUS)) {
      const grpc::Status status = batch->GetSendStatus();
      if (is_refusal(status.error_code())) log(status);
    }
    batch->Proceed();
  }

 private:
  void log(const grpc::Status& status) {
    const auto refusals = log_.count(RefusalLog::Clock::now());
    if (!refusals) return;
    const std::string_view path = call_.method();
    const grpc::ServerContextBase& context = *call_.server_context();
    spdlog::info("event=refused method={} code={} reason={} peer={} since_last={}{}",
                 path.substr(path.rfind('/') + 1), static_cast<int>(status.error_code()),
                 reason_of(status), printable(context.peer()), *refusals, call_ids_of(context));
  }

  RefusalLog& log_;
  interception::ServerRpcInfo& call_;
};

class LoggedRefusals final : public interception::ServerInterceptorFactoryInterface {
 public:
  explicit LoggedRefusals(RefusalLog& log) : log_(log) {}
  interception::Interceptor* CreateServerInterceptor(interception::ServerRpcInfo* call) override {
    return new LoggedRefusal(log_, *call);
  }

 private:
  RefusalLog& log_;
};

}  // namespace

std::optional<std::uint64_t> RefusalLog::count(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  ++unlogged_;
  if (!lines_.open(now)) return {};
  lines_.take(1);
  return std::exchange(unlogged_, 0);
}

std::unique_ptr<interception::ServerInterceptorFactoryInterface> log_refusals(RefusalLog& log) {
  return std::make_unique<LoggedRefusals>(log);
}

}  // namespace sightline::server::exec

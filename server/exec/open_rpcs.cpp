// Counts the open calls of all services, and waits until there is none.
#include "server/exec/open_rpcs.h"

#include <string_view>

namespace sightline::server::exec {
namespace {

namespace grpc_experimental = grpc::experimental;

/// Counts a call, and lives as long.
class Counted final : public grpc_experimental::Interceptor {
 public:
  explicit Counted(OpenRpcs& calls) : calls_(calls) { calls_.begin(); }
  ~Counted() override { calls_.end(); }
  void Intercept(grpc_experimental::InterceptorBatchMethods* batch) override { batch->Proceed(); }

 private:
  OpenRpcs& calls_;
};

class Counter final : public grpc_experimental::ServerInterceptorFactoryInterface {
 public:
  explicit Counter(OpenRpcs& calls) : calls_(calls) {}
  grpc_experimental::Interceptor* CreateServerInterceptor(
      grpc_experimental::ServerRpcInfo* info) override {
    const bool own = !std::string_view(info->method()).starts_with("/grpc.");
    return own ? new Counted(calls_) : nullptr;
  }

 private:
  OpenRpcs& calls_;
};

}  // namespace

void OpenRpcs::begin() {
  const std::lock_guard lock(mutex_);
  ++open_;
}

void OpenRpcs::end() {
  const std::lock_guard lock(mutex_);
  if (--open_ == 0) none_.notify_all();
}

void OpenRpcs::wait_for_none(std::chrono::milliseconds limit) {
  std::unique_lock lock(mutex_);
  none_.wait_for(lock, limit, [this] { return open_ == 0; });
}

std::unique_ptr<grpc_experimental::ServerInterceptorFactoryInterface> count_calls(OpenRpcs& calls) {
  return std::make_unique<Counter>(calls);
}

}  // namespace sightline::server::exec

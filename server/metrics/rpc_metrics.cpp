// The calls of the server's own services, by method and status.
#include "server/metrics/rpc_metrics.h"

#include <google/protobuf/descriptor.h>

#include <utility>

#include "server/exec/admission.h"
#include "server/exec/rpc_status.h"
#include "server/metrics/latency_buckets.h"

namespace sightline::server::metrics {
namespace {

namespace grpc_experimental = grpc::experimental;
using grpc_experimental::InterceptionHookPoints;

constexpr std::array kServices{"sightline.v1.BlobService", "sightline.v1.RayQueryService",
                               "sightline.v1.SceneService", "sightline.v1.ServerService"};

constexpr std::array kCodes{
    "OK",        "CANCELLED",      "UNKNOWN",           "INVALID_ARGUMENT",   "DEADLINE_EXCEEDED",
    "NOT_FOUND", "ALREADY_EXISTS", "PERMISSION_DENIED", "RESOURCE_EXHAUSTED", "FAILED_PRECONDITION",
    "ABORTED",   "OUT_OF_RANGE",   "UNIMPLEMENTED",     "INTERNAL",           "UNAVAILABLE",
    "DATA_LOSS", "UNAUTHENTICATED"};

const char* type_of(const google::protobuf::MethodDescriptor& method) {
  if (method.client_streaming()) return method.server_streaming() ? "bidi_stream" : "client_stream";
  return method.server_streaming() ? "server_stream" : "unary";
}

}  // namespace

class RpcMetrics::Method {
 public:
  Method(prometheus::Labels labels, prometheus::Counter& started, prometheus::Histogram& seconds)
      : labels_(std::move(labels)), started_(started), seconds_(seconds) {}

  void begin() { started_.Increment(); }
  void observe(double seconds) { seconds_.Observe(seconds); }

  /// A code gets its counter when it is first used: few methods use many.
  prometheus::Counter& handled(std::size_t code, prometheus::Family<prometheus::Counter>& family) {
    prometheus::Counter* counter = handled_[code].load();
    if (counter == nullptr) {
      prometheus::Labels labels = labels_;
      labels["grpc_code"] = kCodes[code];
      counter = &family.Add(labels);  // equal labels get the same counter
      handled_[code].store(counter);
    }
    return *counter;
  }

 private:
  const prometheus::Labels labels_;
  prometheus::Counter& started_;
  prometheus::Histogram& seconds_;
  std::array<std::atomic<prometheus::Counter*>, kCodes.size()> handled_{};
};

namespace {

/// Measures a call, and lives as long.
class MeasuredCall final : public grpc_experimental::Interceptor {
 public:
  MeasuredCall(RpcMetrics& metrics, RpcMetrics::Method& method)
      : metrics_(metrics), method_(method) {
    metrics_.begin(method_);
  }
  ~MeasuredCall() override {
    metrics_.end(method_, code_, std::chrono::steady_clock::now() - begun_);
  }

  void Intercept(grpc_experimental::InterceptorBatchMethods* batch) override {
    if (batch->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS)) {
      const grpc::Status status = batch->GetSendStatus();
      code_ = status.error_code();
      if (code_ == grpc::StatusCode::RESOURCE_EXHAUSTED)
        metrics_.count_refusal(exec::reason_of(status));
    }
    batch->Proceed();
  }

 private:
  RpcMetrics& metrics_;
  RpcMetrics::Method& method_;
  const std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  grpc::StatusCode code_ = grpc::StatusCode::CANCELLED;  // where no status is sent
};

class MeasuredCalls final : public grpc_experimental::ServerInterceptorFactoryInterface {
 public:
  explicit MeasuredCalls(RpcMetrics& metrics) : metrics_(metrics) {}
  grpc_experimental::Interceptor* CreateServerInterceptor(
      grpc_experimental::ServerRpcInfo* info) override {
    RpcMetrics::Method* method = metrics_.find(info->method());
    return method == nullptr ? nullptr : new MeasuredCall(metrics_, *method);
  }

 private:
  RpcMetrics& metrics_;
};

}  // namespace

RpcMetrics::RpcMetrics(prometheus::Registry& registry)
    : started_(prometheus::BuildCounter()
                   .Name("grpc_server_started_total")
                   .Help("Calls that have begun.")
                   .Register(registry)),
      handled_(prometheus::BuildCounter()
                   .Name("grpc_server_handled_total")
                   .Help("Calls that have ended, by the code of their status.")
                   .Register(registry)),
      refused_(prometheus::BuildCounter()
                   .Name("sightline_rejected_total")
                   .Help("Calls that ended with RESOURCE_EXHAUSTED, by the reason.")
                   .Register(registry)),
      seconds_(prometheus::BuildHistogram()
                   .Name("grpc_server_handling_seconds")
                   .Help("Time of a call from its begin to its end.")
                   .Register(registry)) {
  refused_.Add({{"reason", exec::kQueueFull}});
  for (const char* name : kServices) {
    const auto* service =
        google::protobuf::DescriptorPool::generated_pool()->FindServiceByName(name);
    for (int i = 0; service != nullptr && i < service->method_count(); ++i) {
      const google::protobuf::MethodDescriptor& method = *service->method(i);
      const prometheus::Labels labels{{"grpc_service", service->full_name()},
                                      {"grpc_method", method.name()},
                                      {"grpc_type", type_of(method)}};
      auto made = std::make_unique<Method>(labels, started_.Add(labels),
                                           seconds_.Add(labels, kLatencyBuckets));
      made->handled(0, handled_);
      methods_.emplace("/" + service->full_name() + "/" + method.name(), std::move(made));
    }
  }
}

RpcMetrics::~RpcMetrics() = default;

RpcMetrics::Method* RpcMetrics::find(std::string_view path) {
  const auto found = methods_.find(path);
  return found == methods_.end() ? nullptr : found->second.get();
}

void RpcMetrics::begin(Method& method) { method.begin(); }

void RpcMetrics::end(Method& method, grpc::StatusCode code,
                     std::chrono::steady_clock::duration time) {
  constexpr std::size_t kUnknown = grpc::StatusCode::UNKNOWN;
  const auto index = static_cast<std::size_t>(code);
  method.handled(index < kCodes.size() ? index : kUnknown, handled_).Increment();
  method.observe(std::chrono::duration<double>(time).count());
}

void RpcMetrics::count_refusal(const std::string& reason) {
  refused_.Add({{"reason", reason.empty() ? "OTHER" : reason}}).Increment();
}

std::unique_ptr<grpc_experimental::ServerInterceptorFactoryInterface> measure_calls(
    RpcMetrics& metrics) {
  return std::make_unique<MeasuredCalls>(metrics);
}

}  // namespace sightline::server::metrics

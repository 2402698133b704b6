// The calls of the server's own services, by method and status.
#pragma once

#include <grpcpp/support/server_interceptor.h>
#include <prometheus/counter.h>
#include <prometheus/family.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

namespace sightline::server::metrics {

/// Threads: any, for every member.
class RpcMetrics {
 public:
  /// `registry` outlives this object.
  explicit RpcMetrics(prometheus::Registry& registry);
  ~RpcMetrics();

  class Method;
  /// `path`: "/package.Service/Method". Null if it is none of the server's own.
  Method* find(std::string_view path);

  void begin(Method& method);
  void end(Method& method, grpc::StatusCode code, std::chrono::steady_clock::duration time);
  /// Counts a refusal with the reason of its google.rpc.ErrorInfo.
  void count_refusal(const std::string& reason);

 private:
  prometheus::Family<prometheus::Counter>&started_, &handled_, &refused_;
  prometheus::Family<prometheus::Histogram>& seconds_;
  std::map<std::string, std::unique_ptr<Method>, std::less<>> methods_;  // constant once made
};

/// Interceptors for grpc::ServerBuilder that count calls in `metrics`, which must outlive the
/// server.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> measure_calls(
    RpcMetrics& metrics);

}  // namespace sightline::server::metrics

// Counts the open calls of all services, and waits until there is none.
#pragma once

#include <grpcpp/support/server_interceptor.h>

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>

namespace sightline::server::exec {

/// Threads: any, for every member.
class OpenRpcs {
 public:
  void begin();
  void end();
  /// Waits until no call is open, but not longer than `limit`.
  void wait_for_none(std::chrono::milliseconds limit);

 private:
  std::mutex mutex_;
  std::condition_variable none_;
  std::size_t open_ = 0;
};

/// Interceptors for grpc::ServerBuilder that count the calls in `calls`, which must outlive the
/// server. Calls of gRPC's own services, such as a watch of the server's health, are not counted.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> count_calls(OpenRpcs& calls);

}  // namespace sightline::server::exec

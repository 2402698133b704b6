// An asynchronous call: its attempts follow each other on threads of gRPC. Internal to the
// library.
#pragma once

#include <grpcpp/alarm.h>
#include <grpcpp/client_context.h>
#include <grpcpp/support/status.h>

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>

#include "client/calls/attempts.h"
#include "client/calls/connection.h"

namespace sightline::client::calls {

/// Runs a task on a thread of gRPC, never within this call.
void run_soon(std::function<void()> task);

/// Which scene a call is about, as set_route() takes it.
struct Route {
  std::string scene{};
  std::string key{};
};

/// Keeps itself and the connection while it is under way. A requested stop cancels the attempt, or
/// ends the pause before the next one.
class AsyncOperation : public std::enable_shared_from_this<AsyncOperation> {
 public:
  AsyncOperation(const AsyncOperation&) = delete;
  AsyncOperation& operator=(const AsyncOperation&) = delete;
  virtual ~AsyncOperation() = default;

 protected:
  AsyncOperation(std::shared_ptr<const Connection> connection,
                 std::optional<std::chrono::milliseconds> timeout, Repeat repeat, Route route,
                 std::stop_token stop);

  /// Makes the first attempt. Call this once.
  void begin();
  /// Sends the request. When the attempt has ended, a callback calls ended(), within a
  /// CallbackScope in which it also releases what keeps this operation.
  virtual void start(grpc::ClientContext& context) = 0;
  void ended(const grpc::Status& status) noexcept;
  /// Takes the status of the last attempt.
  virtual void complete(const grpc::Status& status) = 0;

  const Connection& connection() const { return *connection_; }
  const std::stop_token& stop() const { return stop_; }

 private:
  struct Cancel {
    AsyncOperation* operation;
    void operator()() const { operation->cancel(); }
  };

  void attempt();
  void attempt_after(std::chrono::milliseconds pause);
  void cancel();

  // Outlives the contexts, which hold the channel, too, and must not be the last to do so.
  std::shared_ptr<const Connection> connection_;
  const std::optional<std::chrono::milliseconds> timeout_;
  const Repeat repeat_;
  const Route route_;
  const std::stop_token stop_;
  std::optional<Attempts> attempts_;
  std::mutex mutex_;
  std::shared_ptr<grpc::ClientContext> context_;  // of the attempt under way
  std::shared_ptr<grpc::Alarm> alarm_;            // of the pause under way
  std::optional<std::stop_callback<Cancel>> on_stop_;
};

}  // namespace sightline::client::calls

// Callbacks release what they hold before their scope ends.
#include "client/calls/async_operation.h"

#include <utility>

#include "client/calls/callback_scope.h"

namespace sightline::client::calls {

void run_soon(std::function<void()> task) {
  // gRPC keeps the callback with the alarm, and the callback must keep the alarm until it has run.
  auto kept = std::make_shared<std::unique_ptr<grpc::Alarm>>(std::make_unique<grpc::Alarm>());
  grpc::Alarm& alarm = **kept;
  alarm.Set(std::chrono::system_clock::now(),
            [kept = std::move(kept), task = std::move(task)](bool) mutable {
              const CallbackScope scope;
              const auto fired = std::move(*kept);
              const auto run = std::move(task);
              run();
            });
}

AsyncOperation::AsyncOperation(std::shared_ptr<const Connection> connection,
                               std::optional<std::chrono::milliseconds> timeout, Repeat repeat,
                               Route route, std::stop_token stop)
    : connection_(std::move(connection)),
      timeout_(timeout),
      repeat_(repeat),
      route_(std::move(route)),
      stop_(std::move(stop)) {}

void AsyncOperation::begin() {
  attempts_.emplace(timeout_, repeat_);
  on_stop_.emplace(stop_, Cancel{this});
  attempt();
}

void AsyncOperation::attempt() {
  auto next = std::make_shared<grpc::ClientContext>();
  grpc::ClientContext& context = *next;
  if (const auto& deadline = attempts_->deadline()) context.set_deadline(*deadline);
  set_route(context, route_.scene, route_.key);
  {
    const std::lock_guard lock(mutex_);
    context_ = std::move(next);
    alarm_.reset();
  }
  // A stop that came before the context was stored has not cancelled it.
  if (stop_.stop_requested()) context.TryCancel();
  start(context);
}

void AsyncOperation::ended(const grpc::Status& status) noexcept {
  bool is_stopped = false;
  if (!status.ok()) {
    if (const auto pause = attempts_->pause(status)) {
      is_stopped = stop_.stop_requested();
      if (!is_stopped) return attempt_after(*pause);
    }
  }
  on_stop_.reset();  // waits for a cancel() that is under way
  context_.reset();
  // A client that is destroyed as soon as the call has completed is then the last owner, and its
  // destructor ends the connection.
  connection_.reset();
  complete(is_stopped ? grpc::Status(grpc::CANCELLED, "cancelled") : status);
}

void AsyncOperation::attempt_after(std::chrono::milliseconds pause) {
  const auto alarm = std::make_shared<grpc::Alarm>();
  {
    const std::lock_guard lock(mutex_);
    alarm_ = alarm;
    alarm->Set(std::chrono::system_clock::now() + pause, [self = shared_from_this()](bool) mutable {
      const CallbackScope scope;
      const auto kept = std::move(self);
      kept->attempt();
    });
  }
  if (stop_.stop_requested()) alarm->Cancel();
}

// gRPC is called without the lock, in case that it runs callbacks at once.
void AsyncOperation::cancel() {
  std::shared_ptr<grpc::ClientContext> context;
  std::shared_ptr<grpc::Alarm> alarm;
  {
    const std::lock_guard lock(mutex_);
    context = context_;
    alarm = alarm_;
  }
  if (alarm != nullptr) alarm->Cancel();
  if (context != nullptr) context->TryCancel();
}

}  // namespace sightline::client::calls

// A broken connection begins the deadline anew, because its attempt may have waited for all of it.
#include "client/calls/attempts.h"

#include <utility>

namespace sightline::client::calls {
namespace {

constexpr int kConnections = 4;

}  // namespace

Attempts::Attempts(std::optional<std::chrono::milliseconds> timeout, Repeat repeat)
    : timeout_(timeout),
      repeat_(repeat),
      backoff_(kConnections),
      deadline_(deadline_after(timeout)),
      retries_(std::in_place, deadline_) {}

std::optional<std::chrono::milliseconds> Attempts::pause(const grpc::Status& status) {
  if (repeat_ == Repeat::kNothing) return {};
  if (const auto refused = retries_->pause(status)) return refused;
  const bool may_reconnect =
      repeat_ == Repeat::kRefusalsAndBreaks && is_broken_connection(rpc_error(status).code);
  if (!may_reconnect || !backoff_.again()) return {};
  const std::chrono::milliseconds pause = backoff_.pause();
  if (timeout_) deadline_ = deadline_after(pause + *timeout_);
  retries_.emplace(deadline_);
  return pause;
}

}  // namespace sightline::client::calls

// One call in JSON: a message each way, and a status.
#include "server/admin/json_call.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "server/admin/json_codec.h"
#include "server/exec/rpc_status.h"

namespace sightline::server::admin {

Status JsonCalls::Call::start(Tunnel& tunnel, std::function<void()> ended) {
  const auto method = json_method(request_.method);
  if (!method) return method.error();
  method_ = *method;
  std::optional<std::chrono::system_clock::time_point> deadline;
  if (!request_.timeout.empty()) {
    const auto timeout = parse_timeout(request_.timeout);
    if (!timeout) return timeout.error();
    deadline = std::chrono::system_clock::now() + *timeout;
  }
  {
    const std::lock_guard lock(mutex_);
    if (cancelled_) return Error{Code::kCancelled, "the client is gone", {}};
  }
  auto message = message_of_json(*method_->input_type(), request_.body);
  request_.body = {};
  if (!message) return message.error();
  // gRPC may answer a call whose deadline has passed.
  if (deadline && std::chrono::system_clock::now() >= *deadline)
    return Error{Code::kDeadlineExceeded, "the Grpc-Timeout has passed", {}};
  const std::string path = fmt::format("/{}/{}", method_->service()->full_name(), method_->name());
  // The events keep the call until the last of them.
  auto opened = TunnelCall::open(
      tunnel,
      {.method = path,
       .authorization = request_.authorization,
       .peer = request_.peer,
       .metadata = request_.metadata,
       .deadline = deadline},
      {.message = [self = shared_from_this()](std::string came) { self->take(std::move(came)); },
       .taken = [](std::size_t) {},
       .ended =
           [self = shared_from_this(), ended = std::move(ended)](const grpc::Status& status) {
             {
               const std::lock_guard lock(self->mutex_);
               self->status_ = status;
               self->over_ = true;
               self->call_.reset();
             }
             ended();
           }});
  if (!opened) return opened.error();
  const std::shared_ptr<TunnelCall> call = *opened;
  bool wants = false, cancelled = false;
  {
    const std::lock_guard lock(mutex_);
    if (!over_) call_ = call;
    wants = wants_;
    cancelled = cancelled_;
  }
  call->send(*message, true);
  if (wants) call->want_next();
  if (cancelled) call->cancel();
  return {};
}

/// Asks for another message, in whose place the end comes.
void JsonCalls::Call::take(std::string message) {
  std::shared_ptr<TunnelCall> call;
  {
    const std::lock_guard lock(mutex_);
    message_ = std::move(message);
    call = call_;
    wants_ = call == nullptr;
  }
  if (call != nullptr) call->want_next();
}

HttpReply JsonCalls::Call::answer() const {
  if (!status_.ok()) {
    HttpReply reply = json_error(exec::error_of(status_));
    reply.retry =
        exec::asks_to_retry(status_) || status_.error_code() == grpc::StatusCode::UNAVAILABLE;
    return reply;
  }
  const auto text = json_of_message(*method_->output_type(), message_.value_or(""));
  if (!text) return json_error(text.error());
  return {.body = *text, .type = "application/json"};
}

void JsonCalls::Call::cancel() {
  std::shared_ptr<TunnelCall> call;
  {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
    call = call_;
  }
  if (call != nullptr) call->cancel();
}

}  // namespace sightline::server::admin

// An asynchronous call with one message each way. Internal to the library.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <utility>

#include "client/async_call.h"
#include "client/calls/async_operation.h"
#include "client/calls/callback_scope.h"
#include "client/calls/connection.h"
#include "client/result.h"

namespace sightline::client::calls {

/// Begins a call when it is invoked, once; the argument then takes the result on a thread of gRPC.
template <class T>
using Begin = typename AsyncCall<T>::Begin;

/// Begins nothing: the result is the error.
template <class T>
Begin<T> refused(Error error) {
  return [error = std::move(error)](std::function<void(Result<T>)> done) {
    run_soon([error, done = std::move(done)]() noexcept { done(error); });
  };
}

template <class Request, class Response>
using StartUnary = void (*)(const Connection& connection, grpc::ClientContext& context,
                            const Request& request, Response& response,
                            std::function<void(grpc::Status)> ended);

template <class T, class Request, class Response>
class UnaryCall final : public AsyncOperation {
 public:
  using Done = std::function<void(Result<T>)>;
  /// Makes the result of the answer.
  using Read = std::function<Result<T>(const Response&)>;

  UnaryCall(std::shared_ptr<const Connection> connection,
            std::optional<std::chrono::milliseconds> timeout, Repeat repeat, Route route,
            std::stop_token stop, Request request, StartUnary<Request, Response> begins, Read read)
      : AsyncOperation(std::move(connection), timeout, repeat, std::move(route), std::move(stop)),
        request_(std::move(request)),
        start_(begins),
        read_(std::move(read)) {}

  void begin(Done done) {
    done_ = std::move(done);
    AsyncOperation::begin();
  }

 private:
  void start(grpc::ClientContext& context) override {
    start_(connection(), context, request_, response_,
           [this, self = shared_from_this()](const grpc::Status& status) mutable {
             const CallbackScope scope;
             const auto kept = std::move(self);
             ended(status);
           });
  }
  void complete(const grpc::Status& status) override {
    const Done done = std::move(done_);
    done(status.ok() ? read_(response_) : Result<T>(rpc_error(status, stop())));
  }

  const Request request_;
  const StartUnary<Request, Response> start_;
  const Read read_;
  Response response_;
  Done done_;
};

/// The arguments are those of UnaryCall.
template <class T, class Request, class Response>
Begin<T> unary_call(std::shared_ptr<const Connection> connection,
                    std::optional<std::chrono::milliseconds> timeout, Repeat repeat, Route route,
                    std::stop_token stop, Request request, StartUnary<Request, Response> start,
                    std::function<Result<T>(const Response&)> read) {
  const auto call = std::make_shared<UnaryCall<T, Request, Response>>(
      std::move(connection), timeout, repeat, std::move(route), std::move(stop), std::move(request),
      start, std::move(read));
  return [call](std::function<void(Result<T>)> done) { call->begin(std::move(done)); };
}

}  // namespace sightline::client::calls

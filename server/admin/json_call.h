// One call in JSON: a message each way, and a status.
#pragma once

#include <google/protobuf/descriptor.h>
#include <grpcpp/support/status.h>

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "server/admin/json_calls.h"
#include "server/admin/tunnel_call.h"

namespace sightline::server::admin {

/// Threads: cancel() any; the others that of JsonCalls, one after the other.
class JsonCalls::Call : public std::enable_shared_from_this<Call> {
 public:
  Call(Request request, Done done) : request_(std::move(request)), done_(std::move(done)) {}

  /// Makes the call. `ended` is called once, on a thread of gRPC, unless this returns an error.
  Status start(Tunnel& tunnel, std::function<void()> ended);

  /// What came, once it has ended.
  HttpReply answer() const;

  /// Passes this reply on; the first and only one.
  void reply(const HttpReply& reply) { done_(reply); }

  /// Its client is gone: it ends soon.
  void cancel();

 private:
  void take(std::string message);

  Request request_;
  const Done done_;
  const google::protobuf::MethodDescriptor* method_ = nullptr;

  std::mutex mutex_;
  std::shared_ptr<TunnelCall> call_;
  bool cancelled_ = false;
  bool over_ = false;
  bool wants_ = false;  // a message came before call_ was known
  std::optional<std::string> message_;
  grpc::Status status_;
};

}  // namespace sightline::server::admin

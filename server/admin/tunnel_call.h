// A call of the admin port, in the form that fits every method: streams of bytes both ways.
#pragma once

#include <grpcpp/client_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/client_callback.h>

#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/admin/tunnel.h"

namespace sightline::server::admin {

/// A call lives until its `ended` event, and as long as others hold it. Threads: any, for every
/// member.
class TunnelCall final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  /// Called on threads of gRPC.
  struct Events {
    std::function<void(std::string message)> message;  ///< No other comes before want_next().
    std::function<void(std::size_t bytes)> taken;      ///< How many of send()'s bytes were taken.
    std::function<void(const grpc::Status& status)> ended;  ///< The last event.
  };

  struct Request {
    const std::string& method;         ///< "/sightline.v1.SceneService/GetScene".
    const std::string& authorization;  ///< May be empty.
    const std::string& peer;           ///< The peer that it is made for; see exec::made_for().
    std::vector<std::pair<std::string, std::string>> metadata{};  ///< More of it.
    std::optional<std::chrono::system_clock::time_point> deadline{};
  };

  /// The first message is wanted from the beginning. Errors, after which no event comes:
  /// kUnauthenticated (what `authorization` has is no header), kInvalidArgument (nor is other
  /// metadata), kUnavailable (the tunnel was stopped).
  static Result<std::shared_ptr<TunnelCall>> open(Tunnel& tunnel, const Request& request,
                                                  Events events);

  /// Sends a message; nothing: only the end of all messages. Returns the bytes that wait until they
  /// are taken; none if the call takes nothing any more.
  std::size_t send(const std::optional<std::string>& message, bool last);
  /// Asks for the next message. Call it after an event with one.
  void want_next();
  /// Cancels the call: no message comes any more.
  void cancel();

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;

 private:
  struct Outgoing {
    std::optional<grpc::ByteBuffer> message;
    std::size_t bytes = 0;
    bool last = false;
  };

  TunnelCall(Tunnel& tunnel, Events events) : tunnel_(tunnel), events_(std::move(events)) {}
  void write_next();
  void start_no_more();

  Tunnel& tunnel_;
  const Events events_;
  grpc::ClientContext context_;
  std::shared_ptr<TunnelCall> self_;  // until OnDone()
  grpc::ByteBuffer incoming_;

  std::mutex mutex_;
  std::deque<Outgoing> outgoing_;  // the first is being written
  bool reading_ = true;
  bool closed_ = false;  // the sender sends no more
  bool cancelled_ = false;
  bool over_ = false;  // nothing may be started any more
};

}  // namespace sightline::server::admin

// The WebSocket of a live page, with its calls.
#include "server/admin/web_socket.h"

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <chrono>
#include <mutex>
#include <utility>

namespace sightline::server::admin {

namespace websocket = boost::beast::websocket;
using boost::system::error_code;
using page::v1::TunnelRequest;
using page::v1::TunnelResponse;

namespace {

/// What a page may call.
constexpr std::string_view kServices = "/sightline.v1.";

constexpr websocket::stream_base::timeout kTimeouts{
    .handshake_timeout = std::chrono::seconds(5),
    .idle_timeout = std::chrono::seconds(20),
    .keep_alive_pings = true,
};

}  // namespace

void WebSocket::start(Stream stream, Request request, Tunnel& tunnel) {
  const std::shared_ptr<WebSocket> made(
      new WebSocket(std::move(stream), std::move(request), tunnel));
  made->accept();
}

WebSocket::WebSocket(Stream stream, Request request, Tunnel& tunnel)
    : socket_(std::move(stream)), request_(std::move(request)), tunnel_(tunnel) {
  const std::lock_guard lock(tunnel_.mutex_);
  ++tunnel_.sockets_;
}

WebSocket::~WebSocket() {
  for (const auto& [number, call] : calls_) call->cancel();
  const std::lock_guard lock(tunnel_.mutex_);
  --tunnel_.sockets_;
}

void WebSocket::accept() {
  socket_.set_option(kTimeouts);
  socket_.read_message_max(Tunnel::kMaxMessage);
  socket_.binary(true);
  socket_.async_accept(request_, [self = shared_from_this()](const error_code& error) {
    if (!error) self->read();
  });
}

void WebSocket::read() {
  socket_.async_read(buffer_, [self = shared_from_this()](const error_code& error, std::size_t) {
    if (error) return;
    TunnelRequest request;
    const boost::asio::const_buffer bytes = self->buffer_.cdata();
    const bool good =
        request.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())) && self->take(request);
    self->buffer_.consume(bytes.size());
    if (good) return self->read();
    self->socket_.async_close(websocket::close_code::policy_error, [self](const error_code&) {});
  });
}

/// Returns false if the request breaks the rules.
bool WebSocket::take(const TunnelRequest& request) {
  const auto found = calls_.find(request.call());
  if (!request.method().empty()) {
    if (found != calls_.end()) return false;
    open(request);
    return true;
  }
  if (found == calls_.end()) return true;  // it has just ended
  if (request.has_message() || request.last()) {
    found->second->send(request.has_message() ? std::optional(request.message()) : std::nullopt,
                        request.last());
  }
  if (request.cancel()) found->second->cancel();
  return true;
}

void WebSocket::open(const TunnelRequest& request) {
  if (!request.method().starts_with(kServices))
    return end(request.call(), {grpc::StatusCode::UNIMPLEMENTED, "the page may not call this"});
  if (calls_.size() >= Tunnel::kMaxCalls)
    return end(request.call(), {grpc::StatusCode::RESOURCE_EXHAUSTED, "too many calls are open"});
  const auto on_socket = [weak = weak_from_this(), executor = socket_.get_executor()](auto act) {
    boost::asio::post(executor, [weak, act = std::move(act)]() mutable {
      if (const auto self = weak.lock()) act(*self);
    });
  };
  const std::uint32_t number = request.call();
  const auto call = TunnelCall::open(
      tunnel_, request.method(), request.authorization(),
      {.message =
           [on_socket, number](std::string message) {
             on_socket([number, message = std::move(message)](WebSocket& self) mutable {
               self.deliver(number, std::move(message));
             });
           },
       .ended =
           [on_socket, number](const grpc::Status& status) {
             on_socket([number, status](WebSocket& self) { self.end(number, status); });
           }});
  if (call == nullptr) return end(number, {grpc::StatusCode::UNAVAILABLE, "the server stops"});
  calls_[number] = call;
  if (request.has_message() || request.last()) {
    call->send(request.has_message() ? std::optional(request.message()) : std::nullopt,
               request.last());
  }
}

void WebSocket::deliver(std::uint32_t call, std::string message) {
  TunnelResponse response;
  response.set_call(call);
  response.set_message(std::move(message));
  send(response);
  waiting_.push_back(call);
  want_more();
}

/// Of the calls, unless the page is behind.
void WebSocket::want_more() {
  if (unsent_bytes_ > Tunnel::kMaxUnsent) return;
  for (const std::uint32_t number : std::exchange(waiting_, {})) {
    if (const auto found = calls_.find(number); found != calls_.end()) found->second->want_next();
  }
}

void WebSocket::end(std::uint32_t call, const grpc::Status& status) {
  calls_.erase(call);
  TunnelResponse response;
  response.set_call(call);
  response.mutable_end()->set_code(static_cast<std::uint32_t>(status.error_code()));
  response.mutable_end()->set_message(status.error_message());
  response.mutable_end()->set_details(status.error_details());
  send(response);
}

void WebSocket::send(const TunnelResponse& response) {
  unsent_.push_back(response.SerializeAsString());
  unsent_bytes_ += unsent_.back().size();
  if (unsent_.size() == 1) write();
}

void WebSocket::write() {
  socket_.async_write(boost::asio::buffer(unsent_.front()),
                      [self = shared_from_this()](const error_code& error, std::size_t) {
                        if (error) return;
                        self->unsent_bytes_ -= self->unsent_.front().size();
                        self->unsent_.pop_front();
                        if (!self->unsent_.empty()) self->write();
                        self->want_more();
                      });
}

}  // namespace sightline::server::admin

// The WebSocket of a live page, with its calls.
#include "server/admin/web_socket.h"

#include <spdlog/spdlog.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <chrono>
#include <optional>
#include <utility>

#include "proto/printable.h"
#include "server/exec/caller.h"
#include "server/exec/rpc_status.h"

namespace sightline::server::admin {

namespace websocket = boost::beast::websocket;
using boost::system::error_code;
using page::v1::TunnelRequest;
using page::v1::TunnelResponse;

namespace {

/// What a page may call.
constexpr std::string_view kServices = "/sightline.v1.";
constexpr std::size_t kLongestMethod = 128;

constexpr websocket::stream_base::timeout kTimeouts{
    .handshake_timeout = std::chrono::seconds(5),
    .idle_timeout = std::chrono::seconds(20),
    .keep_alive_pings = true,
};

/// While the socket is not read, what the page answers to pings is not seen: the time of
/// Tunnel::limit_ is over before this.
constexpr websocket::stream_base::timeout kNotReading{
    .handshake_timeout = kTimeouts.handshake_timeout,
    .idle_timeout = std::chrono::seconds(120),
    .keep_alive_pings = true,
};

/// Whether a page may call the method, whose name becomes a header.
bool may_call(std::string_view method) {
  return method.starts_with(kServices) && method.size() <= kLongestMethod && is_visible(method);
}

}  // namespace

void WebSocket::start(Stream stream, Request request, Tunnel& tunnel, const std::string& peer) {
  const std::shared_ptr<WebSocket> made(
      new WebSocket(std::move(stream), std::move(request), tunnel, peer));
  made->position_->close = [weak = std::weak_ptr(made)] {
    if (const auto self = weak.lock()) self->give_up();
  };
  made->accept();
}

WebSocket::WebSocket(Stream stream, Request request, Tunnel& tunnel, const std::string& peer)
    : socket_(std::move(stream)),
      request_(std::move(request)),
      tunnel_(tunnel),
      peer_(peer),
      position_(tunnel_.pages_.insert(tunnel_.pages_.end(), {exec::caller_of(peer).principal, {}})),
      late_(socket_.get_executor()) {}

WebSocket::~WebSocket() {
  cancel_calls();
  tunnel_.pages_.erase(position_);
}

void WebSocket::accept() {
  socket_.set_option(kTimeouts);
  socket_.read_message_max(Tunnel::kMaxMessage);
  socket_.binary(true);
  socket_.async_accept(request_, [self = shared_from_this()](const error_code& error) {
    if (!error) self->read();
  });
}

/// Whether the page is behind with reading, or its calls are with taking messages.
bool WebSocket::is_behind() const {
  return unsent_bytes_ > Tunnel::kMaxUnsent || untaken_ > Tunnel::kMaxUntaken;
}

/// Reads the next message, now or when less waits. Call it after one was read.
void WebSocket::read_on() {
  if (ended_) return;
  if (!is_behind()) return read();
  paused_ = true;
  socket_.set_option(kNotReading);
  if (unsent_.empty()) restart_timer();
}

void WebSocket::read() {
  socket_.async_read(buffer_, [self = shared_from_this()](const error_code& error, std::size_t) {
    if (error) return;
    TunnelRequest request;
    const boost::asio::const_buffer bytes = self->buffer_.cdata();
    const bool good =
        request.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())) && self->take(request);
    self->buffer_.consume(bytes.size());
    if (good) return self->read_on();
    self->refuse();
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
  pass_on(found->second, request);
  if (request.cancel()) found->second.call->cancel();
  return true;
}

void WebSocket::open(const TunnelRequest& request) {
  if (!may_call(request.method()))
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
      tunnel_,
      {.method = request.method(), .authorization = request.authorization(), .peer = peer_},
      {.message =
           [on_socket, number](std::string message) {
             on_socket([number, message = std::move(message)](WebSocket& self) mutable {
               self.deliver(number, std::move(message));
             });
           },
       .taken =
           [on_socket, number](std::size_t bytes) {
             on_socket([number, bytes](WebSocket& self) { self.taken(number, bytes); });
           },
       .ended =
           [on_socket, number](const grpc::Status& status) {
             on_socket([number, status](WebSocket& self) { self.end(number, status); });
           }});
  if (!call) return end(number, exec::to_grpc(call.error()));
  pass_on(calls_[number] = {.call = *call}, request);
}

void WebSocket::pass_on(Call& call, const TunnelRequest& request) {
  if (!request.has_message() && !request.last()) return;
  const std::size_t bytes = call.call->send(
      request.has_message() ? std::optional(request.message()) : std::nullopt, request.last());
  call.untaken += bytes;
  untaken_ += bytes;
}

void WebSocket::taken(std::uint32_t call, std::size_t bytes) {
  const auto found = calls_.find(call);
  if (found == calls_.end()) return;
  found->second.untaken -= bytes;
  untaken_ -= bytes;
  want_more();
}

void WebSocket::deliver(std::uint32_t call, std::string message) {
  if (unsent_bytes_ > Tunnel::kMaxUnsent && unsent_bytes_ + message.size() > Tunnel::kMostUnsent)
    return give_up();
  TunnelResponse response;
  response.set_call(call);
  response.set_message(std::move(message));
  send(response);
  waiting_.push_back(call);
  want_more();
}

/// Reads from the calls and from the page, as far as they are not behind.
void WebSocket::want_more() {
  if (ended_) return;
  if (unsent_bytes_ <= Tunnel::kMaxUnsent) {
    for (const std::uint32_t number : std::exchange(waiting_, {})) {
      if (const auto found = calls_.find(number); found != calls_.end())
        found->second.call->want_next();
    }
  }
  if (!paused_) return;
  if (!is_behind()) {
    paused_ = false;
    socket_.set_option(kTimeouts);
    if (unsent_.empty()) late_.cancel();
    read();
  } else if (unsent_.empty()) {
    restart_timer();
  }
}

void WebSocket::end(std::uint32_t call, const grpc::Status& status) {
  if (const auto found = calls_.find(call); found != calls_.end()) {
    untaken_ -= found->second.untaken;
    calls_.erase(found);
  }
  TunnelResponse response;
  response.set_call(call);
  response.mutable_end()->set_code(static_cast<std::uint32_t>(status.error_code()));
  response.mutable_end()->set_message(status.error_message());
  response.mutable_end()->set_details(status.error_details());
  send(response);
  want_more();
}

void WebSocket::send(const TunnelResponse& response) {
  if (ended_) return;
  unsent_.push_back(response.SerializeAsString());
  unsent_bytes_ += unsent_.back().size() + Tunnel::kMessageCost;
  if (unsent_.size() == 1) write();
}

void WebSocket::write() {
  restart_timer();
  socket_.async_write(boost::asio::buffer(unsent_.front()),
                      [self = shared_from_this()](const error_code& error, std::size_t) {
                        if (error) return self->give_up();
                        self->unsent_bytes_ -= self->unsent_.front().size() + Tunnel::kMessageCost;
                        self->unsent_.pop_front();
                        if (!self->unsent_.empty()) self->write();
                        self->want_more();
                      });
}

/// Restarts the time in which the page must read something, or its calls take something.
void WebSocket::restart_timer() {
  late_.expires_after(tunnel_.limit_);
  // A socket that is neither read nor written lives by this alone.
  const auto held = unsent_.empty() ? shared_from_this() : nullptr;
  late_.async_wait([held, weak = weak_from_this()](const error_code& error) {
    const auto self = weak.lock();
    if (error || self == nullptr || (self->unsent_.empty() && !self->paused_)) return;
    spdlog::info("event=page_given_up peer={} unread={} untaken={}", self->peer_,
                 self->unsent_bytes_, self->untaken_);
    self->give_up();
  });
}

void WebSocket::refuse() {
  cancel_calls();
  ended_ = true;
  socket_.async_close(websocket::close_code::policy_error,
                      [self = shared_from_this()](const error_code&) {});
}

void WebSocket::give_up() {
  ended_ = true;
  cancel_calls();
  boost::beast::get_lowest_layer(socket_).close();
  late_.cancel();
}

void WebSocket::cancel_calls() {
  for (const auto& [number, call] : std::exchange(calls_, {})) call.call->cancel();
  untaken_ = 0;
}

}  // namespace sightline::server::admin

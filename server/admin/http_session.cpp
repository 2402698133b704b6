// One connection of the HTTP server: one request, and its reply or a WebSocket.
#include "server/admin/http_session.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <array>
#include <boost/asio/post.hpp>
#include <boost/beast/core/bind_handler.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <cstddef>
#include <string>
#include <utility>

#include "server/admin/json_call.h"
#include "server/admin/json_codec.h"
#include "server/admin/tunnel.h"
#include "server/admin/web_socket.h"
#include "server/exec/caller.h"
#include "server/exec/rpc_status.h"
#include "server/exec/trace_context.h"

namespace sightline::server::admin {

namespace http = boost::beast::http;
using boost::system::error_code;

namespace {

/// What pages may load and do: nothing but what comes from here.
constexpr const char* kContentPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

int family_of(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  return address.ss_family;
}

std::string address_text(int family, const void* address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  return inet_ntop(family, address, text.data(), text.size()) != nullptr ? text.data() : "";
}

/// The peer as gRPC names it: an IPv4 address has one form, whatever socket it came through. All
/// peers of a Unix socket have one name.
std::string peer_name(int socket) {
  sockaddr_storage peer{};
  socklen_t size = sizeof peer;
  if (getpeername(socket, reinterpret_cast<sockaddr*>(&peer), &size) != 0) return {};
  if (peer.ss_family == AF_UNIX) return "unix:";
  if (peer.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(peer);
    return fmt::format("ipv4:{}:{}", address_text(AF_INET, &v4.sin_addr), ntohs(v4.sin_port));
  }
  const auto& v6 = reinterpret_cast<const sockaddr_in6&>(peer);
  const in6_addr& address = v6.sin6_addr;
  if (IN6_IS_ADDR_V4MAPPED(&address)) {
    constexpr std::size_t kMappedAt = 12;
    return fmt::format("ipv4:{}:{}", address_text(AF_INET, address.s6_addr + kMappedAt),
                       ntohs(v6.sin6_port));
  }
  return fmt::format("ipv6:%5B{}%5D:{}", address_text(AF_INET6, &address), ntohs(v6.sin6_port));
}

Stream make_stream(boost::asio::io_context& context, net::Descriptor socket) {
  // Replies are written whole: nothing is gained by waiting for more.
  const int on = 1;
  setsockopt(socket.number(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  const boost::asio::generic::stream_protocol protocol(family_of(socket.number()), 0);
  Stream stream(context);
  stream.socket().assign(protocol, socket.release());
  return stream;
}

/// Whether a Content-Type is that of JSON.
bool is_json_type(boost::beast::string_view field) {
  const std::string_view all(field.data(), field.size());
  std::string type;
  for (const char c : all) {
    if (c != ' ' && c != '\t' && c != '"')
      type += c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  }
  return type == "application/json" || type == "application/json;charset=utf-8";
}

/// Whether the peer sent something else than HTTP; false if it has gone.
bool is_malformed(const error_code& error) {
  return error.category() == error_code(http::error::bad_method).category() &&
         error != http::error::end_of_stream && error != http::error::partial_message;
}

}  // namespace

std::shared_ptr<HttpSession> HttpSession::start(boost::asio::io_context& context,
                                                net::Descriptor socket, PageThread& pages,
                                                Tunnel* tunnel, JsonCalls* json) {
  std::shared_ptr<HttpSession> made(
      new HttpSession(context, std::move(socket), pages, tunnel, json));
  made->read();
  return made;
}

HttpSession::HttpSession(boost::asio::io_context& context, net::Descriptor socket,
                         PageThread& pages, Tunnel* tunnel, JsonCalls* json)
    : stream_(make_stream(context, std::move(socket))),
      peer_(peer_name(stream_.socket().native_handle())),
      address_(exec::caller_of(peer_).principal),
      pages_(pages),
      tunnel_(tunnel),
      json_(json) {
  parser_.header_limit(HttpServer::kMaxRequest);
  parser_.body_limit(JsonCalls::kMaxBody);
}

void HttpSession::close() { stream_.close(); }

void HttpSession::read() {
  stream_.expires_after(HttpServer::kTimeout);
  http::async_read_header(
      stream_, buffer_, parser_, [self = shared_from_this()](const error_code& error, std::size_t) {
        if (!error) return self->answer();
        if (error == http::error::header_limit || error == http::error::buffer_overflow)
          return self->write({.code = 431, .body = "the request is too large\n"});
        if (error == http::error::body_limit) return self->refuse_size();
        if (is_malformed(error)) self->write({.code = 400, .body = "this is not HTTP/1.1\n"});
      });
}

void HttpSession::answer() {
  const auto& request = parser_.get();
  if (is_json()) return read_json();
  if (request.method() != http::verb::get && request.method() != http::verb::head)
    return write({.code = 405, .body = "only GET and HEAD are answered\n"});
  const std::string_view target(request.target().data(), request.target().size());
  if (boost::beast::websocket::is_upgrade(request)) return upgrade();
  const std::string_view path = target.substr(0, target.find('?'));
  // The reply to /livez shows that this thread works, whatever a page waits for.
  is_probe_ = path == kAlivePath || path == kReadyPath;
  if (path == kAlivePath) return write({.body = "alive\n"});
  ask(std::string(path));
}

void HttpSession::ask(std::string path) {
  const bool waits = pages_.make(
      std::move(path), is_probe_ ? Urgency::kProbe : Urgency::kPage,
      // The session must not end on the thread of the pages.
      [self = shared_from_this()](const HttpReply& reply) mutable {
        const auto thread = self->stream_.get_executor();
        boost::asio::post(thread, [self = std::move(self), reply] { self->write(reply); });
      });
  if (!waits) write({.code = 503, .body = "too many requests wait for pages\n"});
}

void HttpSession::upgrade() {
  const auto field = [&](http::field name) {
    const auto value = parser_.get()[name];
    return std::string_view(value.data(), value.size());
  };
  if (tunnel_ == nullptr) return write({.code = 404, .body = "there is no WebSocket here\n"});
  if (const Status may =
          tunnel_->admit(field(http::field::origin), field(http::field::host), address_);
      !may)
    return write({.code = 403, .body = may.error().message + "\n"});
  stream_.expires_never();
  WebSocket::start(std::move(stream_), parser_.release(), *tunnel_, peer_);
}

bool HttpSession::is_json() const {
  return json_ != nullptr && parser_.get().target().starts_with(
                                 boost::beast::string_view(kJsonPath.data(), kJsonPath.size()));
}

void HttpSession::refuse_size() {
  HttpReply reply{.code = 413,
                  .body = fmt::format("a body of more than {} bytes\n", JsonCalls::kMaxBody)};
  if (body_ || is_json()) {
    reply = json_error({Code::kResourceExhausted,
                        fmt::format("the body has more than {} bytes", JsonCalls::kMaxBody),
                        "BODY_TOO_LARGE"});
    reply.code = 413;
  }
  write(reply);
}

/// What the headers of a call must be.
Result<JsonCalls::Request> HttpSession::json_request() const {
  const auto& request = parser_.get();
  const auto field = [&](auto name) {
    const auto value = request[name];
    return std::string(value.data(), value.size());
  };
  if (const Status may = json_->check(field(http::field::origin), field(http::field::host)); !may)
    return may.error();
  JsonCalls::Request call;
  call.authorization = field(http::field::authorization);
  call.peer = peer_;
  call.timeout = field("Grpc-Timeout");
  for (const char* name : {"Authorization", "Grpc-Timeout", exec::kTraceParent, exec::kRequestId}) {
    if (request.count(name) < 2) continue;
    return exec::invalid_argument(fmt::format("the header {} is there twice", name), "BAD_HEADER");
  }
  for (const char* name : {exec::kTraceParent, exec::kRequestId}) {
    if (request.count(name) == 1) call.metadata.emplace_back(name, field(name));
  }
  const auto target = request.target();
  call.method = std::string(target.data(), target.size()).substr(kJsonPath.size());
  return call;
}

void HttpSession::read_json() {
  const auto& request = parser_.get();
  const auto refuse = [&](int code, std::string message, std::string reason) {
    HttpReply reply = json_error(exec::invalid_argument(std::move(message), std::move(reason)));
    reply.code = code;
    reply.allow = "POST";
    write(reply);
  };
  if (request.method() != http::verb::post)
    return refuse(405, "a call in JSON is made by POST", "BAD_HTTP_METHOD");
  if (!is_json_type(request[http::field::content_type]) ||
      request.count(http::field::content_encoding) != 0)
    return refuse(415, "the body of a call is application/json in UTF-8, not compressed",
                  "BAD_CONTENT_TYPE");
  auto call = json_request();
  if (!call) return write(json_error(call.error()));
  if (const auto method = json_method(call->method); !method)
    return write(json_error(method.error()));
  body_.emplace(std::move(parser_));
  body_->body_limit(JsonCalls::kMaxBody);
  http::async_read(stream_, buffer_, *body_,
                   [self = shared_from_this(), call = *std::move(call)](const error_code& error,
                                                                        std::size_t) mutable {
                     if (!error) return self->call(std::move(call));
                     if (error == http::error::body_limit) return self->refuse_size();
                     if (is_malformed(error))
                       self->write(json_error(exec::invalid_argument(
                           "the body's chunks are not as HTTP/1.1 has them", "BAD_BODY")));
                   });
}

void HttpSession::call(JsonCalls::Request request) {
  request.body = std::move(body_->get().body());
  stream_.expires_never();
  call_ = json_->begin(std::move(request), [self = shared_from_this()](const HttpReply& reply) {
    boost::asio::post(self->stream_.get_executor(), [self, reply] {
      self->answered_ = true;
      self->write(reply);
    });
  });
  watch();
}

/// Cancels the call if the peer goes before it has its answer.
void HttpSession::watch() {
  stream_.socket().async_wait(
      boost::asio::socket_base::wait_read, [self = shared_from_this()](const error_code& error) {
        if (self->answered_) return;
        char byte = 0;
        const bool sent_more = !error && recv(self->stream_.socket().native_handle(), &byte, 1,
                                              MSG_PEEK | MSG_DONTWAIT) > 0;
        if (sent_more) return;  // a second request, which no one reads
        if (const auto call = self->call_.lock()) call->cancel();
      });
}

void HttpSession::write(const HttpReply& reply) {
  response_ = Response(static_cast<http::status>(reply.code), 11);
  response_.set(http::field::content_type, reply.type);
  response_.set(http::field::cache_control, "no-store");
  response_.set("X-Content-Type-Options", "nosniff");
  response_.set("Content-Security-Policy", kContentPolicy);
  if (reply.code == 405) response_.set(http::field::allow, reply.allow);
  if (reply.code == 401) response_.set(http::field::www_authenticate, "Bearer");
  if (reply.retry) response_.set(http::field::retry_after, "1");
  response_.keep_alive(false);
  response_.body() = reply.body;
  response_.prepare_payload();
  if (!body_ && parser_.is_header_done() && parser_.get().method() == http::verb::head)
    response_.body().clear();  // the length stays
  stream_.expires_after(HttpServer::kTimeout);
  http::async_write(
      stream_, response_, [self = shared_from_this()](const error_code& error, std::size_t) {
        error_code ignored;
        self->stream_.socket().shutdown(boost::asio::socket_base::shutdown_send, ignored);
        self->is_probe_ = false;
        if (!error) self->linger();
      });
}

/// Reads what the peer goes on to send until it closes: closing before would reset the connection,
/// and the peer might lose the reply.
void HttpSession::linger() {
  buffer_.clear();
  stream_.async_read_some(buffer_.prepare(HttpServer::kMaxRequest),
                          [self = shared_from_this()](const error_code& error, std::size_t) {
                            if (!error) self->linger();
                          });
}

}  // namespace sightline::server::admin

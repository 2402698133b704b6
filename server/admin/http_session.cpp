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

#include "server/admin/tunnel.h"
#include "server/admin/web_socket.h"
#include "server/exec/caller.h"

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

/// Whether the peer sent something else than HTTP; false if it has gone.
bool is_malformed(const error_code& error) {
  return error.category() == error_code(http::error::bad_method).category() &&
         error != http::error::end_of_stream && error != http::error::partial_message;
}

}  // namespace

std::shared_ptr<HttpSession> HttpSession::start(boost::asio::io_context& context,
                                                net::Descriptor socket, PageThread& pages,
                                                Tunnel* tunnel) {
  std::shared_ptr<HttpSession> made(new HttpSession(context, std::move(socket), pages, tunnel));
  made->read();
  return made;
}

HttpSession::HttpSession(boost::asio::io_context& context, net::Descriptor socket,
                         PageThread& pages, Tunnel* tunnel)
    : stream_(make_stream(context, std::move(socket))),
      peer_(peer_name(stream_.socket().native_handle())),
      address_(exec::caller_of(peer_).principal),
      pages_(pages),
      tunnel_(tunnel) {
  parser_.header_limit(HttpServer::kMaxRequest);
}

void HttpSession::close() { stream_.close(); }

void HttpSession::read() {
  stream_.expires_after(HttpServer::kTimeout);
  http::async_read_header(
      stream_, buffer_, parser_, [self = shared_from_this()](const error_code& error, std::size_t) {
        if (!error) return self->answer();
        if (error == http::error::header_limit || error == http::error::buffer_overflow)
          return self->write({.code = 431, .body = "the request is too large\n"});
        if (is_malformed(error)) self->write({.code = 400, .body = "this is not HTTP/1.1\n"});
      });
}

void HttpSession::answer() {
  const auto& request = parser_.get();
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

void HttpSession::write(const HttpReply& reply) {
  response_ = Response(static_cast<http::status>(reply.code), 11);
  response_.set(http::field::content_type, reply.type);
  response_.set(http::field::cache_control, "no-store");
  response_.set("X-Content-Type-Options", "nosniff");
  response_.set("Content-Security-Policy", kContentPolicy);
  if (reply.code == 405) response_.set(http::field::allow, "GET, HEAD");
  response_.keep_alive(false);
  response_.body() = reply.body;
  response_.prepare_payload();
  if (parser_.is_header_done() && parser_.get().method() == http::verb::head)
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

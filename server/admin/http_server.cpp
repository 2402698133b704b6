// A small HTTP/1.1 server for probes and metrics.
#include "server/admin/http_server.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <exception>
#include <system_error>
#include <utility>

namespace sightline::server::admin {
namespace {

/// After accept() has failed for want of descriptors.
constexpr std::chrono::milliseconds kPause{100};

constexpr std::string_view kEndOfHeaders = "\r\n\r\n";

const char* text_of(int code) {
  switch (code) {
    case 200:
      return "OK";
    case 400:
      return "Bad Request";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 431:
      return "Request Header Fields Too Large";
    case 503:
      return "Service Unavailable";
    default:
      return "Internal Server Error";
  }
}

std::string encode(const HttpReply& reply, bool with_body) {
  return fmt::format(
      "HTTP/1.1 {} {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nCache-Control: no-store\r\n"
      "X-Content-Type-Options: nosniff\r\nConnection: close\r\n{}\r\n{}",
      reply.code, text_of(reply.code), reply.type, reply.body.size(),
      reply.code == 405 ? "Allow: GET, HEAD\r\n" : "", with_body ? reply.body : std::string());
}

/// Whether a socket would rather be asked later.
bool is_later() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace

HttpServer::HttpServer(std::vector<net::Descriptor> listeners, Handler handler)
    : listeners_(std::move(listeners)),
      handler_(std::move(handler)),
      wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!wake_) throw std::system_error(errno, std::generic_category(), "eventfd");
  connections_.reserve(kMaxConnections + 1);
  thread_ = std::thread([this] { run(); });
}

HttpServer::~HttpServer() {
  eventfd_write(wake_.number(), 1);
  thread_.join();
}

void HttpServer::run() {
  std::vector<pollfd> polled;
  polled.reserve(1 + listeners_.size() + kMaxConnections);
  for (;;) {
    const auto now = Clock::now();
    polled.assign(1, {.fd = wake_.number(), .events = POLLIN, .revents = 0});
    for (const Connection& one : connections_) {
      const short events = one.reply.empty() ? POLLIN : POLLOUT;
      polled.push_back({.fd = one.socket.number(), .events = events, .revents = 0});
    }
    const std::size_t first_listener = polled.size();
    for (const net::Descriptor& listener : listeners_) {
      const int number = now < accept_from_ ? -1 : listener.number();  // -1: poll() skips it
      polled.push_back({.fd = number, .events = POLLIN, .revents = 0});
    }
    const auto wait = std::chrono::ceil<std::chrono::milliseconds>(next_end() - now);
    const auto wait_ms = static_cast<int>(std::max<std::int64_t>(wait.count(), 0));
    if (poll(polled.data(), polled.size(), wait_ms) < 0) {
      if (errno != EINTR) std::this_thread::sleep_for(kPause);
      continue;
    }
    if (polled[0].revents != 0) return;
    for (std::size_t i = 0; i < connections_.size(); ++i) {
      if (polled[1 + i].revents != 0) serve(connections_[i]);
      connections_[i].over |= Clock::now() >= connections_[i].end;
    }
    std::erase_if(connections_, [](const Connection& one) { return one.over; });
    for (std::size_t i = 0; i < listeners_.size(); ++i) {
      if (polled[first_listener + i].revents != 0) accept_from(listeners_[i].number());
    }
  }
}

/// When something must be done that no socket tells of.
HttpServer::Clock::time_point HttpServer::next_end() const {
  auto next = Clock::now() + kTimeout;
  if (Clock::now() < accept_from_) next = std::min(next, accept_from_);
  for (const Connection& one : connections_) next = std::min(next, one.end);
  return next;
}

void HttpServer::accept_from(int listener) {
  net::Descriptor socket(accept4(listener, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (!socket) {
    if (!is_later() && errno != ECONNABORTED) accept_from_ = Clock::now() + kPause;
    return;
  }
  if (connections_.size() >= kMaxConnections) connections_.erase(connections_.begin());
  connections_.push_back({.socket = std::move(socket), .end = Clock::now() + kTimeout});
}

void HttpServer::serve(Connection& connection) {
  try {
    if (connection.reply.empty()) read(connection);
    if (!connection.reply.empty()) write(connection);
  } catch (const std::exception&) {
    connection.over = true;  // no memory even for the reply that says so
  }
}

void HttpServer::read(Connection& connection) {
  std::array<char, 2048> bytes;
  const auto count = recv(connection.socket.number(), bytes.data(), bytes.size(), 0);
  if (count <= 0) {
    connection.over = count == 0 || !is_later();
    return;
  }
  connection.request.append(bytes.data(), static_cast<std::size_t>(count));
  if (connection.request.find(kEndOfHeaders) != std::string::npos) {
    connection.reply = reply_to(connection.request);
  } else if (connection.request.size() > kMaxRequest) {
    connection.reply = encode({.code = 431, .body = "the request is too large\n"}, true);
  }
}

void HttpServer::write(Connection& connection) {
  const std::string_view rest = std::string_view(connection.reply).substr(connection.sent);
  const auto count = send(connection.socket.number(), rest.data(), rest.size(), MSG_NOSIGNAL);
  if (count < 0) {
    connection.over = !is_later();
    return;
  }
  connection.sent += static_cast<std::size_t>(count);
  connection.over = connection.sent == connection.reply.size();
}

std::string HttpServer::reply_to(std::string_view request) const {
  const std::string_view line = request.substr(0, request.find("\r\n"));
  const std::size_t method_end = line.find(' ');
  const std::size_t target_end = line.rfind(' ');
  if (method_end == target_end || !line.substr(target_end + 1).starts_with("HTTP/1."))
    return encode({.code = 400, .body = "this is not HTTP/1.1\n"}, true);
  const std::string_view method = line.substr(0, method_end);
  const std::string_view target = line.substr(method_end + 1, target_end - method_end - 1);
  if (method != "GET" && method != "HEAD")
    return encode({.code = 405, .body = "only GET and HEAD are answered\n"}, true);
  try {
    return encode(handler_(target.substr(0, target.find('?'))), method == "GET");
  } catch (const std::exception& thrown) {
    return encode({.code = 500, .body = fmt::format("{}\n", thrown.what())}, method == "GET");
  }
}

}  // namespace sightline::server::admin

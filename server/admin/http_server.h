// A small HTTP/1.1 server for probes and metrics.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "server/net/descriptor.h"

namespace sightline::server::admin {

struct HttpReply {
  int code = 200;
  std::string body;
  std::string type = "text/plain; charset=utf-8";
};

/// Answers GET and HEAD, one request a connection, from one thread. What a peer may do is limited:
/// the connections at a time, the bytes of a request, and the time until its reply is read. When
/// all connections are taken, the oldest is closed.
class HttpServer {
 public:
  static constexpr std::size_t kMaxConnections = 32;
  static constexpr std::size_t kMaxRequest = 8192;  ///< Bytes of the request line and the headers.
  static constexpr std::chrono::seconds kTimeout{5};

  /// Makes the reply to the path of a request, without its query. Runs on the server's thread. What
  /// it throws becomes a reply with code 500.
  using Handler = std::function<HttpReply(std::string_view path)>;

  /// Answers from now on. `listeners` do not block. Throws std::system_error.
  HttpServer(std::vector<net::Descriptor> listeners, Handler handler);
  /// Closes all connections.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  struct Connection {
    net::Descriptor socket;
    Clock::time_point end;  // closed then, whatever its state
    std::string request{}, reply{};
    std::size_t sent = 0;
    bool over = false;
  };

  void run();
  void accept_from(int listener);
  void serve(Connection& connection);
  void read(Connection& connection);
  void write(Connection& connection);
  std::string reply_to(std::string_view request) const;
  Clock::time_point next_end() const;

  const std::vector<net::Descriptor> listeners_;
  const Handler handler_;
  net::Descriptor wake_;
  std::vector<Connection> connections_;  // oldest first
  Clock::time_point accept_from_{};      // not before: there was no descriptor left
  std::thread thread_;
};

}  // namespace sightline::server::admin

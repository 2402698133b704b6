// HTTP/1.1 for probes, metrics, calls in JSON and the live page, and the WebSockets of that page.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "server/net/descriptor.h"

namespace sightline::server::admin {

/// What probes ask for.
inline constexpr std::string_view kAlivePath = "/livez", kReadyPath = "/readyz";

struct HttpReply {
  int code = 200;
  std::string body;
  std::string type = "text/plain; charset=utf-8";
  bool retry = false;               ///< Whether the same may be asked again soon.
  std::string allow = "GET, HEAD";  ///< With code 405: the methods that there are.
};

class HttpSession;
class JsonCalls;
class PageThread;
class Tunnel;

/// Answers GET and HEAD, one request a connection, from one thread; /livez itself, all else by a
/// handler on a second one, which may wait. POST is for JsonCalls. What a peer may do is limited:
/// the connections at a time, the bytes of a request, and the time until its reply is read. When
/// all connections are taken, the oldest of the address that has most is closed, but a probe last
/// of all. WebSockets have limits of their own: see Tunnel.
class HttpServer {
 public:
  static constexpr std::size_t kMaxConnections = 32;
  static constexpr std::size_t kMaxRequest = 8192;  ///< Bytes of the request line and the headers.
  static constexpr std::chrono::seconds kTimeout{5};

  /// Makes the reply to the path of a request, without its query. Runs on a thread of its own, once
  /// at a time. What it throws becomes a reply with code 500.
  using Handler = std::function<HttpReply(std::string_view path)>;

  /// Answers from now on. `listeners` do not block. `tunnel` outlives this object; null: there are
  /// no WebSockets. `json`, which makes its calls by `tunnel`, outlives it, too; null: there are no
  /// calls in JSON.
  HttpServer(std::vector<net::Descriptor> listeners, Handler handler, Tunnel* tunnel = nullptr,
             JsonCalls* json = nullptr);
  /// Closes all connections.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

 private:
  struct Listener {
    boost::asio::posix::stream_descriptor descriptor;
    boost::asio::steady_timer pause;
  };

  void close_one();
  void wait_at(Listener& listener);
  void accept_from(Listener& listener);

  Tunnel* const tunnel_;
  JsonCalls* const json_;
  boost::asio::io_context context_{1};
  std::unique_ptr<PageThread> pages_;  // ends before the context, to which it sends pages
  std::list<Listener> listeners_;
  std::list<std::weak_ptr<HttpSession>> sessions_;  // oldest first
  std::thread thread_;
};

}  // namespace sightline::server::admin

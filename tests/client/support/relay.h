// A port that forwards connections to a server, and breaks them on request.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <list>
#include <mutex>
#include <string>
#include <thread>

namespace sightline::tests {

class Relay {
 public:
  /// Forwards to 127.0.0.1:port.
  explicit Relay(int port);
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;
  ~Relay();

  const std::string& endpoint() const { return endpoint_; }
  /// Breaks all open connections.
  void cut();
  /// Connections made from now on break after this many bytes to the server or from it. 0: no
  /// limit.
  void cut_each_after(std::size_t to_server, std::size_t from_server);
  /// While held, connections stay open and no bytes are forwarded to the server.
  void hold(bool held);
  int connections() const;

 private:
  struct Connection;
  void accept_all();
  void pump(Connection& connection, bool to_server);
  void cut(Connection& connection);

  int port_;
  int listener_;
  std::string endpoint_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool held_ = false;
  bool ended_ = false;
  std::size_t to_server_ = 0, from_server_ = 0;
  std::list<Connection> connections_;
  std::thread accepter_;
};

}  // namespace sightline::tests

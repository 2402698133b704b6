// One thread accepts connections, two more for each connection copy its bytes.
#include "tests/client/support/relay.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <system_error>

namespace sightline::tests {
namespace {

sockaddr_in address_of(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

int socket_or_throw() {
  const int file = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (file < 0) throw std::system_error(errno, std::generic_category(), "socket");
  return file;
}

bool send_all(int file, const char* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t sent = ::send(file, bytes, count, MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes += sent;
    count -= static_cast<std::size_t>(sent);
  }
  return true;
}

}  // namespace

struct Relay::Connection {
  int client = -1, server = -1;
  std::size_t to_server = 0, from_server = 0;  // Limits in bytes, 0: none
  std::thread up, down;
};

Relay::Relay(int port) : port_(port), listener_(socket_or_throw()) {
  sockaddr_in address = address_of(0);
  socklen_t length = sizeof(address);
  auto* const plain = reinterpret_cast<sockaddr*>(&address);
  if (::bind(listener_, plain, length) != 0 || ::listen(listener_, 16) != 0 ||
      ::getsockname(listener_, plain, &length) != 0)
    throw std::system_error(errno, std::generic_category(), "relay");
  endpoint_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  accepter_ = std::thread([this] { accept_all(); });
}

Relay::~Relay() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
  ::shutdown(listener_, SHUT_RDWR);
  accepter_.join();
  cut();
  for (Connection& connection : connections_) {
    connection.up.join();
    connection.down.join();
    ::close(connection.client);
    ::close(connection.server);
  }
  ::close(listener_);
}

void Relay::cut() {
  const std::lock_guard lock(mutex_);
  for (Connection& connection : connections_) cut(connection);
}

void Relay::cut(Connection& connection) {
  ::shutdown(connection.client, SHUT_RDWR);
  ::shutdown(connection.server, SHUT_RDWR);
}

void Relay::cut_each_after(std::size_t to_server, std::size_t from_server) {
  const std::lock_guard lock(mutex_);
  to_server_ = to_server;
  from_server_ = from_server;
}

void Relay::hold(bool held) {
  {
    const std::lock_guard lock(mutex_);
    held_ = held;
  }
  changed_.notify_all();
}

int Relay::connections() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(connections_.size());
}

void Relay::accept_all() {
  while (true) {
    const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0) return;
    const int server = socket_or_throw();
    const sockaddr_in address = address_of(port_);
    if (::connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
      ::close(client);
      ::close(server);
      continue;
    }
    const std::lock_guard lock(mutex_);
    Connection& connection = connections_.emplace_back();
    connection.client = client;
    connection.server = server;
    connection.to_server = to_server_;
    connection.from_server = from_server_;
    connection.up = std::thread([this, &connection] { pump(connection, true); });
    connection.down = std::thread([this, &connection] { pump(connection, false); });
  }
}

void Relay::pump(Connection& connection, bool to_server) {
  const int from = to_server ? connection.client : connection.server;
  const int to = to_server ? connection.server : connection.client;
  const std::size_t limit = to_server ? connection.to_server : connection.from_server;
  std::array<char, 4096> bytes{};
  std::size_t passed = 0;
  while (true) {
    const ssize_t count = ::recv(from, bytes.data(), bytes.size(), 0);
    if (count <= 0) break;
    if (to_server) {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return !held_ || ended_; });
    }
    auto now = static_cast<std::size_t>(count);
    const bool is_last = limit > 0 && passed + now >= limit;
    if (is_last) now = limit - passed;
    passed += now;
    if (!send_all(to, bytes.data(), now) || is_last) break;
  }
  cut(connection);
}

}  // namespace sightline::tests

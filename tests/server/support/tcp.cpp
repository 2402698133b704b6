// Connections of TCP, with nothing on top.
#include "tests/server/support/tcp.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstdint>

namespace sightline::tests {
namespace {

sockaddr_in address_of(const std::string& host, int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  EXPECT_EQ(inet_pton(AF_INET, host.c_str(), &address.sin_addr), 1);
  return address;
}

}  // namespace

server::net::Descriptor connect_tcp(int port, const std::string& from) {
  server::net::Descriptor made(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const sockaddr_in own = address_of(from, 0);
  EXPECT_EQ(bind(made.number(), reinterpret_cast<const sockaddr*>(&own), sizeof own), 0);
  EXPECT_TRUE(connect_tcp(made, port));
  return made;
}

bool connect_tcp(const server::net::Descriptor& socket, int port) {
  const sockaddr_in peer = address_of("127.0.0.1", port);
  return connect(socket.number(), reinterpret_cast<const sockaddr*>(&peer), sizeof peer) == 0;
}

void send_bytes(const server::net::Descriptor& connection, const std::string& bytes) {
  static_cast<void>(send(connection.number(), bytes.data(), bytes.size(), MSG_NOSIGNAL));
}

std::string receive_bytes(const server::net::Descriptor& connection) {
  std::string bytes(4096, '\0');
  const ssize_t got = recv(connection.number(), bytes.data(), bytes.size(), 0);
  bytes.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  return bytes;
}

}  // namespace sightline::tests

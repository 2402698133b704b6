// A socket that listens but never accepts: the system completes the connections.
#include "tests/client/support/silent_port.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace sightline::tests {

SilentPort::SilentPort() : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  auto* const any = reinterpret_cast<sockaddr*>(&address);
  EXPECT_EQ(::bind(socket_, any, size), 0);
  EXPECT_EQ(::listen(socket_, 8), 0);
  EXPECT_EQ(::getsockname(socket_, any, &size), 0);
  endpoint_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
}

SilentPort::~SilentPort() { ::close(socket_); }

}  // namespace sightline::tests

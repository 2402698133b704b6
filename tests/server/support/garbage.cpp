// Peers that do not speak HTTP/2.
#include "tests/server/support/garbage.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

#include "tests/support/random.h"

namespace sightline::tests {
namespace {

void send_and_await_close(int port, const std::string& bytes) {
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  static_cast<void>(send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL));
  char answer[4096];
  while (recv(fd, answer, sizeof(answer), 0) > 0) {
  }
  close(fd);
}

}  // namespace

void send_garbage(int port) {
  Random random(1);
  std::string noise(65536, '\0');
  for (char& c : noise) c = static_cast<char>(random.next());
  send_and_await_close(port, noise);
  send_and_await_close(port, "GET / HTTP/1.1\r\nHost: x\r\n\r\n");
  send_and_await_close(port, "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + noise);
}

}  // namespace sightline::tests

// Peers that do not speak HTTP/2.
#include "tests/server/support/garbage.h"

#include <string>

#include "tests/server/support/tcp.h"
#include "tests/support/random.h"

namespace sightline::tests {
namespace {

void send_and_await_close(int port, const std::string& bytes) {
  const auto connection = connect_tcp(port);
  send_bytes(connection, bytes);
  while (!receive_bytes(connection).empty()) {
  }
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

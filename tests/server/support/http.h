// Requests to an admin port.
#pragma once

#include <string>

#include "tests/server/support/tcp.h"

namespace sightline::tests {

/// The whole reply to GET of this path, its headers included.
inline std::string http_get(int port, const std::string& path) {
  const server::net::Descriptor connection = connect_tcp(port);
  send_bytes(connection, "GET " + path + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
  std::string reply;
  for (std::string some; !(some = receive_bytes(connection)).empty();) reply += some;
  return reply;
}

}  // namespace sightline::tests

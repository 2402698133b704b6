// Connections of TCP, with nothing on top.
#pragma once

#include <string>

#include "server/net/descriptor.h"

namespace sightline::tests {

/// A connection to this port of this machine, from this address of it.
server::net::Descriptor connect_tcp(int port, const std::string& from = "127.0.0.1");

/// Connects this socket; false if the port does not listen.
bool connect_tcp(const server::net::Descriptor& socket, int port);

void send_bytes(const server::net::Descriptor& connection, const std::string& bytes);

/// Waits for bytes; empty once the peer has closed the connection.
std::string receive_bytes(const server::net::Descriptor& connection);

}  // namespace sightline::tests

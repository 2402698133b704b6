// Where a connection comes from.
#pragma once

#include <string>

namespace sightline::server::net {

/// The peer's address without its port; of a Unix socket, the user at the other end. Empty: not
/// known.
std::string address_of(int connection);

}  // namespace sightline::server::net

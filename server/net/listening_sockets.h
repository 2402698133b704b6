// Sockets that listen.
#pragma once

#include <cstdint>
#include <vector>

#include "accel/result.h"
#include "server/net/descriptor.h"
#include "server/net/listen_address.h"

namespace sightline::server::net {

/// The sockets of one address: a name may stand for several addresses. They do not block.
struct ListeningSockets {
  std::vector<Descriptor> sockets;
  std::uint16_t port = 0;  ///< The same for all.
};

/// Errors: kUnavailable, with the system's reason (the name is unknown, the port is in use).
Result<ListeningSockets> listen_on(const ListenAddress& address);

}  // namespace sightline::server::net

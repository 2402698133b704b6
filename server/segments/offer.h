// To whom a server offers segments.
#pragma once

#include <cstdint>
#include <string_view>

namespace sightline::server::segments {

enum class Offer : std::uint8_t {
  kOff,    ///< To no client.
  kUnix,   ///< To peers at a Unix socket.
  kLocal,  ///< Also to peers at a loopback address, of which one may be a proxy for others.
};

/// Whether a peer, as gRPC writes it ("unix:path", "ipv4:127.0.0.1:4711"), is one of them.
bool includes(Offer offer, std::string_view peer);

}  // namespace sightline::server::segments

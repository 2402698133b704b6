// To whom a server offers segments.
#include "server/segments/offer.h"

#include <algorithm>
#include <array>

namespace sightline::server::segments {

bool includes(Offer offer, std::string_view peer) {
  const auto begins = [peer](std::string_view text) { return peer.starts_with(text); };
  constexpr std::array<std::string_view, 2> kUnixPeers{"unix:", "unix-abstract:"};
  // gRPC 1.51 writes the brackets of an IPv6 address in percent.
  constexpr std::array<std::string_view, 3> kLoopbackPeers{"ipv4:127.",
                                                           "ipv6:[::1]:", "ipv6:%5B::1%5D:"};
  if (offer == Offer::kOff) return false;
  return std::ranges::any_of(kUnixPeers, begins) ||
         (offer == Offer::kLocal && std::ranges::any_of(kLoopbackPeers, begins));
}

}  // namespace sightline::server::segments

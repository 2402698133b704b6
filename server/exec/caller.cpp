// Who makes a call.
#include "server/exec/caller.h"

namespace sightline::server::exec {

Caller caller_of(std::string_view peer) {
  const std::size_t port = peer.starts_with("ip") ? peer.rfind(':') : std::string_view::npos;
  return {std::string(peer.substr(0, port)), std::string(peer)};
}

}  // namespace sightline::server::exec

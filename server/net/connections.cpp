// The open connections, at most a limit, shared fairly by the addresses that they come from.
#include "server/net/connections.h"

#include <sys/socket.h>

#include <algorithm>
#include <utility>

namespace sightline::server::net {

std::optional<int> Connections::gives_way_to(const std::string& address) const {
  const auto most = std::max_element(
      by_address_.begin(), by_address_.end(),
      [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
  const auto mine = by_address_.find(address);
  const std::size_t count = mine == by_address_.end() ? 0 : mine->second.size();
  if (most == by_address_.end() || most->second.size() < count + 2) return std::nullopt;
  return most->second.back().number();
}

void Connections::add(const std::string& address, Descriptor socket) {
  addresses_.emplace(socket.number(), address);
  by_address_[address].push_back(std::move(socket));
}

void Connections::remove(int socket) {
  const auto found = addresses_.find(socket);
  if (found == addresses_.end()) return;
  const auto sockets = by_address_.find(found->second);
  std::erase_if(sockets->second, [&](const Descriptor& one) { return one.number() == socket; });
  if (sockets->second.empty()) by_address_.erase(sockets);
  addresses_.erase(found);
}

void Connections::shut_down() {
  for (const auto& [socket, address] : addresses_) shutdown(socket, SHUT_RDWR);
}

}  // namespace sightline::server::net

// The connections that were ended for what their clients sent.
#include "server/net/ended_connections.h"

#include <spdlog/spdlog.h>

#include <utility>

namespace sightline::server::net {

void EndedConnections::add(Abuse abuse, const std::string& peer) {
  counts_[static_cast<std::size_t>(abuse)].fetch_add(1);
  const auto now = std::chrono::steady_clock::now();
  const std::lock_guard lock(mutex_);
  if (addresses_.size() < kMaxAddresses) addresses_.push_back(peer);
  ++unlogged_;
  if (now - logged_ < std::chrono::seconds(1)) return;
  spdlog::warn("event=connection_ended reason={} peer={} since_last={}", abuse_name(abuse), peer,
               unlogged_);
  logged_ = now;
  unlogged_ = 0;
}

std::vector<std::string> EndedConnections::take_addresses() {
  const std::lock_guard lock(mutex_);
  return std::exchange(addresses_, {});
}

}  // namespace sightline::server::net

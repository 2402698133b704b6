// The servers that answer for the shards of scenes.
#pragma once

#include <grpcpp/server_context.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/shards/peer.h"

namespace sightline::server::shards {

/// Where the peers are, and how they are called.
struct PeerSettings {
  std::string
      addresses;  ///< HOST:PORT,HOST:PORT,... or unix:PATH: that of shard 0 first. Empty: none.
  bool tls = false;
  std::filesystem::path ca;           ///< PEM. Empty: the system's.
  std::filesystem::path certificate;  ///< PEM, shown to peers that ask for one.
  std::filesystem::path key;          ///< The key of the certificate.
};

/// Threads: any, for every member but ping().
class Peers {
 public:
  /// No peers.
  Peers() = default;
  /// Errors: as check(), and kFailedPrecondition, naming a file that cannot be read.
  static Result<Peers> make(const PeerSettings& settings);
  /// Errors: kInvalidArgument, naming the address that is none, has no port or is named twice, or
  /// the number of addresses and its limits.
  static Status check(const PeerSettings& settings);

  bool empty() const { return peers_.empty(); }
  /// How many shards a scene has.
  std::uint32_t size() const { return static_cast<std::uint32_t>(peers_.size()); }
  const std::string& address(std::uint32_t shard) const { return peers_[shard]->address(); }
  Peer& peer(std::uint32_t shard) const { return *peers_[shard]; }

  /// Pings every peer. Call it every kPingEvery, on one thread at a time.
  void ping() const;

  /// The context of a call to a peer on behalf of a call to this server: with its deadline, its
  /// end, its name and its token.
  static Peer::Context context_for(const grpc::CallbackServerContext& caller);

 private:
  std::vector<std::unique_ptr<Peer>> peers_;
};

}  // namespace sightline::server::shards

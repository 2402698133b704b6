// What the end of a call to a peer means.
#pragma once

#include <grpcpp/support/status.h>

#include <cstdint>
#include <string>

#include "proto/result.h"
#include "server/shards/peers.h"

namespace sightline::server::shards {

/// Whether the peer is gone, or not at the revision.
bool means_lost(const grpc::Status& ended);

/// The error kUnavailable (SHARD_LOST): the peer `does_not` do what it is asked for.
Error lost_shard(const Peers& peers, std::uint32_t shard, const std::string& does_not);

/// The error that the peer said.
Error error_of_peer(const Peers& peers, std::uint32_t shard, const grpc::Status& said);

/// The rank of how a call ended: 0 with an error, 1 cancelled, 2 OK. The call of the lowest rank
/// shows why calls ended together: others were cancelled because of it.
int rank_of(const grpc::Status& ended);

}  // namespace sightline::server::shards

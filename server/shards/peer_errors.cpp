// Tells a lost peer from one that refuses.
#include "server/shards/peer_errors.h"

#include <fmt/format.h>

#include "server/exec/rpc_status.h"

namespace sightline::server::shards {

bool means_lost(const grpc::Status& ended) {
  switch (ended.error_code()) {
    case grpc::StatusCode::UNAVAILABLE:
    case grpc::StatusCode::DEADLINE_EXCEEDED:
    case grpc::StatusCode::CANCELLED:
    case grpc::StatusCode::UNKNOWN:       // the connection was closed during the call
    case grpc::StatusCode::OUT_OF_RANGE:  // the revision is not kept there
      return true;
    default:
      return false;
  }
}

Error lost_shard(const Peers& peers, std::uint32_t shard, const std::string& does_not) {
  return {Code::kUnavailable,
          fmt::format("shard {} of {} is lost: {} does not {}", shard, peers.size(),
                      peers.address(shard), does_not),
          "SHARD_LOST"};
}

Error error_of_peer(const Peers& peers, std::uint32_t shard, const grpc::Status& said) {
  Error error = exec::error_of(said);
  error.message =
      fmt::format("{} answers for shard {}: {}", peers.address(shard), shard, error.message);
  return error;
}

int rank_of(const grpc::Status& ended) {
  if (ended.ok()) return 2;
  return ended.error_code() == grpc::StatusCode::CANCELLED ? 1 : 0;
}

}  // namespace sightline::server::shards

// Trees that other servers build, each those of its shard of the scene.
#pragma once

#include <grpcpp/server_context.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "proto/result.h"
#include "server/shards/peers.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::shards {

/// A prefetch of one call, without rays. No thread waits for a peer: a call to one ends as those of
/// ShardedCast do.
class ShardedPrefetch {
 public:
  /// `caller`: the call to this server. Both outlive this.
  ShardedPrefetch(const Peers& peers, const grpc::CallbackServerContext& caller);
  ~ShardedPrefetch();

  /// Asks every peer for its shard of what is `asked`. Calls ended() once, when all have ended:
  /// from a thread of gRPC, or before this returns. After that this object may be gone. Called
  /// once.
  void start(const v1::PrefetchRequest& asked, std::function<void()> ended);

  /// How the calls ended. Call it after ended(). Errors: kUnavailable (SHARD_LOST), what a peer
  /// said.
  Status take() const;

  /// Ends the calls soon. Threads: any, at any time.
  void cancel();

  /// Sets the sums of what the peers have reported; none of them before each has.
  /// Threads: any, at any time.
  void report(v1::PrefetchResponse& response) const;

 private:
  class Call;

  void end_one();

  const Peers& peers_;
  const grpc::CallbackServerContext& caller_;
  mutable std::mutex mutex_;  // protects what the calls have reported, and the next two
  std::vector<std::unique_ptr<Call>> calls_;  // shard 0 first; constant from start() on
  bool cancelled_ = false;
  std::function<void()> ended_;
  std::atomic<std::size_t> open_{0};  // calls, and start()
};

}  // namespace sightline::server::shards

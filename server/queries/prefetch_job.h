// Serves one prefetch: decode, admit, build, report progress.
#pragma once

#include <grpcpp/server_context.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "accel/geometry/ray.h"
#include "proto/result.h"
#include "scenegraph/query/build.h"
#include "server/queries/asked_shard.h"
#include "server/queries/cast_job.h"
#include "server/shards/sharded_cast.h"
#include "server/shards/sharded_prefetch.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

inline constexpr int kMaxPrefetchRoots = 4096;
/// Most rays that the servers of the shards cast at a time. Progress is reported after each part.
inline constexpr std::size_t kRaysOfPart = 4096;

/// Serves one call: open(), then run() while report() may be called, then close(). If it
/// is_sharded(), ask() takes the place of run(): once, and again after each time that it has asked.
class PrefetchJob {
 public:
  /// `context`: the call's, which outlives this.
  PrefetchJob(const scenes::Services& services, const grpc::CallbackServerContext& context,
              exec::Caller caller)
      : services_(services),
        context_(context),
        caller_(std::move(caller)),
        trees_of_shards_(services.shard_peers, context) {}

  const exec::Caller& caller() const { return caller_; }

  /// Checks the request, takes the scene's newest revision and admits the rays. Errors:
  /// kInvalidArgument, kNotFound, kFailedPrecondition (SHARDS_DIFFER); as decode_rays and
  /// Admission::admit.
  Status open(const v1::PrefetchRequest& request);

  /// Builds, in the calling thread's arena. Errors: kCancelled; kNotFound, naming a node of the
  /// request that does not exist.
  Status run();

  /// Whether the servers of all shards build, or cast the rays, and this one waits.
  bool is_sharded() const { return is_for_all_shards(query_, services_); }
  /// Takes what the peers have answered, if they were asked, and asks them for the next part. Sets
  /// `asked` if there was one: then calls answered() once, from a thread of gRPC or before this
  /// returns, and this may be gone. Errors: as run(), and of ShardedCast and ShardedPrefetch.
  Status ask(std::function<void()> answered, bool& asked);

  /// Writes the progress of run(), or of the peers. Threads: any, one at a time, until close().
  void report(v1::PrefetchResponse& response);

  /// Makes run() end soon, and the calls that ask() made. Threads: any, at any time.
  void cancel() {
    cancelled_.store(true, std::memory_order_relaxed);
    trees_of_shards_.cancel();
  }

  /// Releases the admission and the revision. The last release of a revision frees its trees, which
  /// may take long.
  void close();

 private:
  using Clock = std::chrono::steady_clock;

  Status check_roots(const v1::PrefetchRequest& request);
  Status build();
  Status grow();
  void report_own(v1::PrefetchResponse& response);
  void open_sharded(const v1::PrefetchRequest& request);
  Status ask_for_trees(std::function<void()> answered, bool& asked);
  Status ask_for_rays(const std::function<void()>& answered, bool& asked);
  std::span<const accel::geometry::Ray> next_rays() const;

  const scenes::Services& services_;
  const grpc::CallbackServerContext& context_;
  const exec::Caller caller_;
  const Clock::time_point begun_ = Clock::now();
  CastQuery query_;
  std::vector<scenegraph::model::NodeId> roots_;
  bool has_rays_ = false;  // or points
  std::vector<accel::geometry::Ray> rays_;
  exec::Quotas::Use quota_;
  exec::Admission::Ticket ticket_;
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot_;
  scenes::RevisionToken revision_;
  std::vector<const scenegraph::model::Mesh*> meshes_;  // whose trees are built
  scenegraph::query::BuildProgress progress_;
  std::uint64_t triangles_reported_ = 0;
  std::atomic<bool> known_{false};  // meshes_ is set
  std::atomic<bool> cancelled_{false};
  bool peers_asked_ = false;             // they have answers to take
  v1::PrefetchRequest asked_for_trees_;  // what peers are asked
  shards::ShardedPrefetch trees_of_shards_;
  std::unique_ptr<shards::ShardedCast> cast_;               // casts the rays, if there are some
  std::shared_ptr<const scenegraph::query::ShardCut> cut_;  // for `cast_`
};

}  // namespace sightline::server::queries

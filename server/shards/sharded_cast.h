// A batch of rays or points that other servers answer, each for a shard of the scene.
#pragma once

#include <grpcpp/server_context.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "accel/geometry/ray.h"
#include "proto/result.h"
#include "scenegraph/query/shard_merge.h"
#include "scenegraph/query/shard_sides.h"
#include "scenegraph/side_rule.h"
#include "server/shards/peers.h"
#include "server/shards/shard_messages.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::shards {

/// What a ray takes in a batch: itself, its question, the answers of a shard and of all.
inline constexpr std::size_t kShardedBytesPerRay = 512;
/// What a listed hit takes, for each shard: in its message, and decoded twice.
inline constexpr std::size_t kShardedBytesPerHit = 192;
/// What the sides of `points` take beside kShardedBytesPerRay, where `shards` are asked.
std::size_t sharded_side_bytes(std::size_t points, const scenegraph::SideQuestion& question,
                               std::size_t shards);

/// Answers that are this much later than the budget of time still count: peers, too, need a moment
/// to end.
inline constexpr std::chrono::milliseconds kAfterBudget{30};

/// The batches of one call. For each batch call begin(), then ask() and take() in turn until ask()
/// returns false. No thread waits for a peer: a call to one ends when it answers, kAfterBudget
/// after the budget of time, when the caller's deadline passes or the caller is gone, and when the
/// peer is lost, of which none is asked. A peer that is late finds its call cancelled.
class ShardedCast {
 public:
  using Clock = std::chrono::steady_clock;

  /// What all batches of a call ask for.
  struct Query {
    scenegraph::QueryKind kind = scenegraph::QueryKind::kClosest;
    bool surface = false;  ///< See TraceOptions, also for max_hits.
    std::uint32_t max_hits = 0;
    /// Rays that a lost shard could change are unanswered; and those that have no answer shortly
    /// before the caller's deadline.
    bool allow_partial = false;
    std::optional<scenegraph::SideQuestion> sides{};  ///< Of points: that their sides are asked.
    bool sides_alone = false;                         ///< And nothing else.
  };

  struct Batch {
    std::span<const accel::geometry::Ray> rays{};  ///< They outlive the batch.
    /// These three are of the revision that every shard answers at.
    std::shared_ptr<const scenegraph::query::ShardCut> cut{};
    std::uint64_t revision = 0;
    std::string token{};
    std::optional<Clock::time_point> budget_ends{};  ///< The time after which rays are unanswered.
  };

  /// `asked`: the first request of the call. `caller`: the call to this server. It and `peers`
  /// outlive every batch. Requests of points are answered with those of points; sides come after
  /// the nearest faces.
  ShardedCast(const Peers& peers, const grpc::CallbackServerContext& caller,
              const v1::CastRaysRequest& asked, const Query& query);
  ShardedCast(const Peers& peers, const grpc::CallbackServerContext& caller,
              const v1::QueryPointsRequest& asked, const Query& query);

  void begin(Batch batch);

  /// Sends the next questions, to several peers at a time, and returns true; then calls answered()
  /// once, when all have ended: from a thread of gRPC, or before this returns. After that this
  /// object may be gone. False: the batch is done, or its time is over.
  bool ask(std::function<void()> answered);

  /// Merges the answers. Call it after answered(). Where the budget was too short for a peer that
  /// answers pings, rays are unanswered. Errors: kUnavailable (SHARD_LOST: a peer does not answer
  /// at this revision, and the batch is not partial), what a peer said, kInternal.
  Status take();

  /// The answers, once the batch is done. With SideRule::kNormal they are the faces at any
  /// distance, also beyond the limits of points; else, of sides alone, there are none.
  const scenegraph::query::ShardMerge& answers() const { return merge_; }
  /// The sides, if they are asked for, once the batch is done.
  const scenegraph::query::ShardSides& sides() const { return sides_; }
  /// The counts of rays and hits in answers(), once the batch is done, and the costs of all shards.
  scenegraph::TraceStats stats() const;

  /// Frees what a large batch has needed. Call it between two batches.
  void rest();

 private:
  struct Call {
    scenegraph::query::ShardQuestion question{};
    Peer::Context context{};
    Messages messages{};
    grpc::Status status{};
    bool late = false;  // the budget was too short, but the peer lives

    const v1::SceneRevision& served() const;
    const HitColumns& columns() const;
    const v1::CastStats& stats() const;
  };

  template <class Request>
  void set_question(const scenegraph::query::ShardQuestion& question, Request& request) const;
  void start(Call& call);
  void end(Call& call);
  void end_one();
  bool may_be_lost(const Call& call) const;
  Error lost(const Call& call) const;
  Status take(const Call& call);
  Status take_hits(const Call& call);
  Status take_sides(const Call& call);
  std::uint32_t budget_ms() const;
  std::vector<scenegraph::query::ShardQuestion> next();
  std::vector<scenegraph::query::ShardQuestion> next_in_time();
  void lose(const scenegraph::query::ShardQuestion& question);
  bool by_normal() const;

  const Peers& peers_;
  const grpc::CallbackServerContext& caller_;
  const Query query_;
  const Messages template_;       // its request is that of all calls
  const Messages side_template_;  // and of those for sides
  Batch batch_;
  std::optional<Clock::time_point> ask_until_, wait_until_;  // the batch's
  scenegraph::query::ShardMerge merge_;
  std::vector<accel::geometry::Ray> unlimited_;  // by normals: the batch's points
  bool at_sides_ = false;                        // merge_ is done
  scenegraph::query::ShardSides sides_;
  scenegraph::TraceStats cost_;
  std::vector<Call> calls_;
  std::function<void()> answered_;
  std::atomic<std::size_t> open_{0};  // calls, and ask()
};

}  // namespace sightline::server::shards

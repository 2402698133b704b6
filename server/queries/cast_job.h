// Serves batches of rays: decode, admit, trace, encode.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "accel/geometry/ray.h"
#include "proto/result.h"
#include "scenegraph/query/selection.h"
#include "scenegraph/trace.h"
#include "server/exec/caller.h"
#include "server/exec/deadlines.h"
#include "server/exec/executors.h"
#include "server/exec/fair_queue.h"
#include "server/queries/batch_rays.h"
#include "server/queries/cast_admission.h"
#include "server/queries/cast_query.h"
#include "server/queries/derived_columns.h"
#include "server/queries/hit_codec.h"
#include "server/queries/hit_pager.h"
#include "server/queries/segment_answer.h"
#include "server/queries/side_columns.h"
#include "server/scenes/revision_wait.h"
#include "server/scenes/services.h"
#include "server/segments/segment.h"
#include "server/shards/sharded_cast.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

/// Casts of up to this number of rays are answered in the thread that asks for them, as far as they
/// meet built cells alone, and take less time than a worker needs to wake up.
inline constexpr std::size_t kImmediateCast = 256;
static_assert(kImmediateCast <= kSmallCast);
static_assert(kRaysPerSlice % kRaysPerBitsByte == 0);

/// Serves one call: open() and pin() once; then for each batch accept() once, and enqueue() until
/// the reply says that there is no more. Rays are read slice by slice in the request, and their
/// hits written to the reply's columns, which have their final size from the first slice on, or
/// slice by slice to a segment. All slices and batches use the same memory.
class CastJob {
 public:
  /// `context`: the call's, which outlives this.
  CastJob(const scenes::Services& services, grpc::CallbackServerContext& context, Replies replies)
      : services_(services),
        context_(context),
        caller_(exec::caller_of(context)),
        replies_(replies),
        admission_(services, caller_, replies) {}

  /// Finds the scene and decodes the query. Errors: kInvalidArgument, kNotFound (also of a segment
  /// that is named), kFailedPrecondition (a shard of another number than this server has peers, or
  /// a server that offers no segments).
  Status open(const v1::CastRaysRequest& request);
  Status open(const v1::QueryPointsRequest& request);
  const std::shared_ptr<scenes::StoredScene>& scene() const { return scene_; }
  const exec::Caller& caller() const { return caller_; }

  /// Sets the revision that answers every batch. Call it after open().
  void pin(std::shared_ptr<const scenegraph::revision::Snapshot> snapshot);
  /// As pin(), to a revision of another scene in the place of the one that open() has found.
  void pin(std::shared_ptr<scenes::StoredScene> scene,
           std::shared_ptr<const scenegraph::revision::Snapshot> snapshot);

  /// Admits the rays of the request, which must not change until the batch's last reply is made.
  /// Errors: as BatchRays::begin, SegmentAnswer::begin, segments::Segments::find and
  /// CastAdmission::admit; kInvalidArgument (a segment is needed and not named, or another one than
  /// the first request has named).
  template <class Request>
  Status accept(const Request& request) {
    begin_batch(request.time_budget_ms());
    if (Status found = find_segment(request); !found) return found;
    if (Status good = batch_.begin(request, bounds_of(request)); !good) return good;
    const std::uint64_t segment_bytes = segment_ ? segment_->size() : 0;
    if (Status good =
            answer_.begin(request.answer(), query_, batch_.size(), batch_.ranges(), segment_bytes);
        !good)
      return good;
    return admit(request.ByteSizeLong());
  }

  /// Call it after accept(). Makes the next reply on workers for casts of this size, after a full
  /// build on background workers if the query asks for one. Then calls done(Status) there. An
  /// immediate cast may be answered, and done() called, before this returns. If the reply says that
  /// there is more, the batch stays admitted, and enqueue() must be called again for the next one.
  /// `reply` must not change meanwhile. Where this server has peers for shards, they trace, and
  /// done() may be called on a thread of gRPC. Errors: kCancelled; kNotFound, naming a node of the
  /// query that does not exist; kFailedPrecondition, a shard of another cut; as
  /// shards::ShardedCast::take.
  using Done = std::function<void(const Status&)>;
  void enqueue(v1::CastRaysResponse& reply, const Done& done);
  /// As enqueue(), in a slice of a job on a worker for small casts: what enqueue() would give to
  /// such a worker is done in the calling thread. Returns whether the job has more, and this must
  /// be called again; if not, this may be gone.
  bool run_slice_here(v1::CastRaysResponse& reply, const Done& done);
  /// Ends a batch that was accepted and is not to be answered.
  void drop_batch();

  /// Makes enqueue() end soon, with an error. Threads: any, at any time.
  void cancel() {
    cancelled_.store(true);
    stopped_.store(true);
  }

  /// Gives the revision away, between two batches: there can be no other batch. Its last owner
  /// frees its trees, which may take long.
  std::shared_ptr<const scenegraph::revision::Snapshot> let_go();
  /// Releases the revision. The last release frees its trees, which may take long.
  void close() { let_go(); }
  /// Frees what a large batch has needed. Call it between two batches.
  void rest();

  /// Whether the last batch has taken `limit` or more since it arrived. 0: never.
  bool is_slow(std::chrono::milliseconds limit) const {
    return limit.count() > 0 && batch_time_ >= limit;
  }
  /// What the log says of the last batch: the scene, the caller, what it was and built.
  std::string slow_description() const;
  /// What the log says of all batches: the scene, the caller, and totals.
  std::string description() const;

 private:
  using Clock = std::chrono::steady_clock;
  /// How far one reply has come.
  enum class Progress : std::uint8_t { kMore, kDone };

  template <class Request>
  Status open_query(const Request& request);
  template <class Request>
  Status find_segment(const Request& request);
  template <class Request>
  BatchRays::Bounds bounds_of(const Request& request) const;
  void begin_batch(std::uint32_t budget_ms);
  Status admit(std::size_t request_bytes);
  bool is_sharded() const { return sharded_ != nullptr; }
  template <class Request>
  void open_sharded(const Request& request);
  void push_sharded(v1::CastRaysResponse& reply, const Done& done);
  Status run_sharded(v1::CastRaysResponse& reply, const Done& done, bool& asked);
  Status begin_sharded();
  std::size_t sharded_part() const;
  Status write_sharded(v1::CastRaysResponse& reply);
  Status write_sharded_hits(v1::CastRaysResponse& reply);
  void write_sharded_sides(const accel::geometry::HitColumns& hits, v1::CastRaysResponse& reply);
  Status write_sharded_lists(v1::CastRaysResponse& reply);
  void push(exec::Slice slice);
  bool builds_first() const;
  bool cast_slice(v1::CastRaysResponse& reply, const Done& done);
  bool is_immediate() const;
  Result<Progress> answer_at_once(v1::CastRaysResponse& reply);
  void push_build(v1::CastRaysResponse& reply, const Done& done);
  void push_cast(v1::CastRaysResponse& reply, const Done& done);
  void end(const Status& status, const Done& done);
  void begin_budget(std::uint32_t milliseconds);
  Status build();
  Status run_slice(v1::CastRaysResponse& reply, Progress& progress);
  Status begin();
  Status trace_slice(v1::CastRaysResponse& reply, Progress& progress);
  void begin_columns(v1::CastRaysResponse& reply);
  /// Where the rows of the next rays are made: in the reply, or in a slice for the segment.
  v1::CastRaysResponse& columns_of(v1::CastRaysResponse& reply) {
    return query_.in_segment ? answer_.slice() : reply;
  }
  /// The row of the next ray there.
  std::size_t row() const { return query_.in_segment ? 0 : answered_; }
  void take_over(std::size_t count);
  Result<scenegraph::TraceStats> trace_rays(std::size_t count,
                                            const scenegraph::TraceOptions& options,
                                            v1::CastRaysResponse& reply);
  Result<scenegraph::TraceStats> trace_hits(const accel::geometry::RayColumns& rays,
                                            accel::geometry::HitColumns& hits,
                                            const scenegraph::TraceOptions& options,
                                            v1::CastRaysResponse& reply);
  Result<scenegraph::TraceStats> trace_with_sides(const accel::geometry::RayColumns& points,
                                                  accel::geometry::HitColumns& hits,
                                                  const scenegraph::TraceOptions& options,
                                                  v1::CastRaysResponse& reply);
  Result<scenegraph::TraceStats> trace_built(std::size_t count, v1::CastRaysResponse& reply,
                                             bool& met_deferred);
  void describe(v1::CastRaysResponse& reply);
  scenegraph::TraceOptions options() const;

  const scenes::Services& services_;
  const grpc::CallbackServerContext& context_;
  const exec::Caller caller_;
  exec::FlowKey flow_;  // after open()
  const Replies replies_;
  CastQuery query_;
  std::shared_ptr<scenes::StoredScene> scene_;  // until pin()
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot_;
  scenes::RevisionToken revision_;
  std::string segment_name_;                          // empty: none. In a stream, of all requests
  std::shared_ptr<const segments::Segment> segment_;  // the batch's; null: it uses none
  BatchRays batch_;
  SegmentAnswer answer_;
  std::size_t answered_ = 0;                // rays of the batch
  std::vector<accel::geometry::Ray> rays_;  // the batch's, for all hits
  std::vector<double> made_;                // the slice's rays that are generated or copied
  std::optional<scenegraph::query::Selection> selection_;
  std::vector<scenegraph::RayTally> tallies_;  // the slice's
  HitPager pager_;
  std::unique_ptr<shards::ShardedCast> sharded_;            // null: this server traces
  std::shared_ptr<const scenegraph::query::ShardCut> cut_;  // the revision's, for `sharded_`
  bool peers_asked_ = false;                                // `sharded_` has answers to take
  Clock::time_point sharded_since_;                         // the batch
  DerivedColumns derived_;                                  // the batch's, unless it lists hits
  SideColumns sides_;                                       // the batch's
  scenegraph::TraceStats build_stats_;                      // a full build for the batch
  scenegraph::TraceStats stats_;                            // the batch's
  CastAdmission admission_;
  Clock::time_point arrived_, waiting_since_;
  Clock::duration queued_{}, traced_{}, batch_time_{};  // the batch's
  bool begun_ = false;                                  // the batch has had a slice
  std::atomic<bool> cancelled_{false};
  bool has_budget_ = false;                        // the batch has a time budget
  Clock::time_point budget_ends_;                  // if it has one
  std::atomic<bool> stopped_{false};               // the batch: cancelled, or out of time
  exec::Deadlines::Alarm alarm_;                   // the batch's; sets stopped_
  std::vector<accel::geometry::HitState> states_;  // the slice's, if the reply has no such column
  // The statistics of all batches.
  scenegraph::TraceStats total_stats_;
  Clock::duration total_queued_{};
};

}  // namespace sightline::server::queries

// Serves batches of rays: decode, admit, trace, encode.
#include "server/queries/cast_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "scenegraph/instances/scene_trees.h"
#include "server/exec/rpc_status.h"
#include "server/queries/asked_shard.h"
#include "server/queries/hit_codec.h"
#include "server/queries/ray_codec.h"
#include "server/scenes/names.h"
#include "server/segments/segments.h"
#include "server/shards/peers.h"

namespace sightline::server::queries {
namespace {

/// A stream that rests keeps the memory for this number of rays.
constexpr std::size_t kIdleRays = 256;

// What a thread that has read a cast does for it by itself: rays between two looks at the clock,
// and about the time that it takes to wake a worker up.
constexpr std::size_t kRaysAtOnce = 16;
static_assert(kRaysAtOnce % kRaysPerBitsByte == 0);
constexpr std::chrono::microseconds kMostAtOnce{250};

/// Most rays of one slice; of points with sides fewer, as each casts rays of its own.
std::size_t rays_per_slice(const CastQuery& query) {
  if (!query.sides) return kRaysPerSlice;
  const std::size_t points = kRaysPerSlice / query.sides->rays;
  return points / kRaysPerBitsByte * kRaysPerBitsByte;
}

bool is_made(const v1::CastRaysRequest& request) { return request.has_generator(); }
bool is_made(const v1::QueryPointsRequest& request) { return request.has_grid(); }

std::uint64_t microseconds(std::chrono::steady_clock::duration time) {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(time).count());
}

}  // namespace

template <class Request>
Status CastJob::open_query(const Request& request) {
  if (Status good = scenes::check_scene_name(request.scene()); !good) return good;
  auto query = decode_query(request, services_.policy);
  if (!query) return query.error();
  if (Status good = check_shard(*query, services_); !good) return good;
  if (!request.segment().empty()) {
    const auto known = services_.segments.find(request.segment(), caller_);
    if (!known) return known.error();
  }
  auto scene = services_.find_for_read(request.scene(), request.consistency());
  if (!scene) return scene.error();
  query_ = std::move(*query);
  segment_name_ = request.segment();
  scene_ = std::move(*scene);
  flow_ = exec::flow_of(caller_, request.scene());
  return {};
}

Status CastJob::open(const v1::CastRaysRequest& request) {
  if (Status opened = open_query(request); !opened) return opened;
  if (is_for_all_shards(query_, services_)) open_sharded(request);
  return {};
}

Status CastJob::open(const v1::QueryPointsRequest& request) {
  if (Status opened = open_query(request); !opened) return opened;
  if (is_for_all_shards(query_, services_)) open_sharded(request);
  return {};
}

void CastJob::pin(std::shared_ptr<const scenegraph::revision::Snapshot> snapshot) {
  scene_->touch();
  revision_ = scene_->token(snapshot->revision());
  snapshot_ = std::move(snapshot);
  scene_.reset();
}

/// Finds the segment that the batch uses, and keeps it until the batch is answered.
template <class Request>
Status CastJob::find_segment(const Request& request) {
  segment_.reset();
  if (!request.segment().empty() && request.segment() != segment_name_) {
    return exec::invalid_argument(
        fmt::format("segment {} is named, but the stream's first request has named {}",
                    exec::quote(request.segment()), exec::quote(segment_name_)),
        "SEGMENT_DIFFERS");
  }
  if (!request.has_shared() && !query_.in_segment) return {};
  if (segment_name_.empty()) {
    return exec::invalid_argument("`shared` and `answer` need a `segment`, and none is named",
                                  "NO_SEGMENT");
  }
  auto found = services_.segments.find(segment_name_, caller_);
  if (!found) return found.error();
  segment_ = std::move(*found);
  return {};
}

template Status CastJob::find_segment(const v1::CastRaysRequest& request);
template Status CastJob::find_segment(const v1::QueryPointsRequest& request);

/// More rays than messages hold, where neither they nor their answers are in one.
template <class Request>
BatchRays::Bounds CastJob::bounds_of(const Request& request) const {
  const bool in_no_message = query_.in_segment && (request.has_shared() || is_made(request));
  return {.segment = segment_.get(),
          .most = in_no_message ? max_shared_rays(services_.admission.limits().rays)
                                : kMaxRaysPerRequest};
}

template BatchRays::Bounds CastJob::bounds_of(const v1::CastRaysRequest& request) const;
template BatchRays::Bounds CastJob::bounds_of(const v1::QueryPointsRequest& request) const;

void CastJob::pin(std::shared_ptr<scenes::StoredScene> scene,
                  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot) {
  scene_ = std::move(scene);
  pin(std::move(snapshot));
}

void CastJob::begin_batch(std::uint32_t budget_ms) {
  arrived_ = Clock::now();
  batch_time_ = {};
  begin_budget(budget_ms);
}

Status CastJob::admit(std::size_t request_bytes) {
  if (Status admitted = admission_.admit(request_bytes, query_, batch_.size(), is_sharded());
      !admitted)
    return admitted;
  queued_ = {};
  begun_ = false;
  return {};
}

/// Begins the time budget of a batch. 0: no bound.
void CastJob::begin_budget(std::uint32_t milliseconds) {
  alarm_ = {};
  stopped_.store(false);
  if (cancelled_.load()) stopped_.store(true);
  has_budget_ = milliseconds > 0;
  if (!has_budget_) return;
  budget_ends_ = arrived_ + std::chrono::milliseconds(milliseconds);
  alarm_ = services_.deadlines.set(budget_ends_, stopped_);
}

void CastJob::enqueue(v1::CastRaysResponse& reply, const Done& done) {
  waiting_since_ = Clock::now();
  Progress progress = Progress::kMore;
  const Status pushed = exec::to_status([&] {
    if (is_immediate()) {
      const auto answered = answer_at_once(reply);
      if (!answered) return Status(answered.error());
      progress = *answered;
    }
    if (progress == Progress::kDone) return Status();
    if (is_sharded()) {
      push_sharded(reply, done);
    } else if (builds_first()) {
      push_build(reply, done);
    } else {
      push_cast(reply, done);
    }
    return Status();
  });
  if (!pushed || progress == Progress::kDone) end(pushed, done);
}

bool CastJob::run_slice_here(v1::CastRaysResponse& reply, const Done& done) {
  if (is_sharded() || builds_first() || batch_.size() > kSmallCast) {
    enqueue(reply, done);
    return false;
  }
  if (!begun_) waiting_since_ = Clock::now();
  return cast_slice(reply, done);
}

/// Whether the batch begins with a full build.
bool CastJob::builds_first() const {
  return !begun_ && query_.growth == scenegraph::Growth::kFull && !snapshot_->is_complete();
}

/// Whether a few rays may be answered in the thread that asks: it must neither build nor wait.
bool CastJob::is_immediate() const {
  if (begun_ || is_sharded() || batch_.size() > kImmediateCast ||
      query_.kind == scenegraph::QueryKind::kAll || query_.shard || query_.sides ||
      (query_.growth == scenegraph::Growth::kFull && !snapshot_->is_complete()))
    return false;
  return snapshot_->shared_trees().are_opened();
}

/// Traces only through cells that are built. Where a ray meets another one, and after some time,
/// workers go on.
Result<CastJob::Progress> CastJob::answer_at_once(v1::CastRaysResponse& reply) {
  const auto begun = Clock::now();
  if (const Status ready = begin(); !ready) return ready.error();
  reply.clear_first_ray();
  reply.clear_more();
  begin_columns(reply);
  auto now = begun;
  while (answered_ < batch_.size() && now - begun <= kMostAtOnce) {
    const std::size_t count = std::min(batch_.size() - answered_, kRaysAtOnce);
    bool met_deferred = false;
    const auto traced = trace_built(count, reply, met_deferred);
    if (!traced) return traced.error();
    if (met_deferred && query_.growth != scenegraph::Growth::kBuiltOnly) break;
    stats_ += *traced;
    take_over(count);
    now = Clock::now();
  }
  traced_ += now - begun;
  waiting_since_ = now;
  if (answered_ < batch_.size()) return Progress::kMore;
  describe(reply);
  return Progress::kDone;
}

/// Traces the next rays, and sets whether one of them met a cell that is not built.
Result<scenegraph::TraceStats> CastJob::trace_built(std::size_t count, v1::CastRaysResponse& reply,
                                                    bool& met_deferred) {
  scenegraph::TraceOptions built_only = options();
  built_only.growth = scenegraph::Growth::kBuiltOnly;
  const auto is_deferred = [](std::uint32_t work) {
    return (work & accel::geometry::kWorkDeferred) != 0;
  };
  if (query_.kind == scenegraph::QueryKind::kCount) {
    auto traced = trace_rays(count, built_only, reply);
    met_deferred = std::any_of(tallies_.begin(), tallies_.end(),
                               [&](const auto& tally) { return is_deferred(tally.work); });
    return traced;
  }
  std::array<std::uint32_t, kRaysAtOnce> work{};
  accel::geometry::HitColumns hits = view_hits(columns_of(reply), row(), count);
  const auto asked = hits.work;
  hits.work = {work.data()};
  auto traced = trace_hits(batch_.view(answered_, count, made_), hits, built_only, reply);
  for (std::size_t i = 0; i < count; ++i) {
    if (asked.is_asked()) asked.set(i, work[i]);
    met_deferred |= is_deferred(work[i]);
  }
  return traced;
}

void CastJob::push_build(v1::CastRaysResponse& reply, const Done& done) {
  services_.compute.enqueue_background(flow_, [this, &reply, done] {
    const Status built = exec::to_status([&] {
      if (Status made = build(); !made) return made;
      push_cast(reply, done);
      return Status();
    });
    if (!built) end(built, done);
    return false;
  });
}

void CastJob::push_cast(v1::CastRaysResponse& reply, const Done& done) {
  push([this, &reply, done] { return cast_slice(reply, done); });
}

/// Returns whether the reply needs more slices; if not, this may be gone.
bool CastJob::cast_slice(v1::CastRaysResponse& reply, const Done& done) {
  Progress progress = Progress::kDone;
  const Status ran = exec::to_status([&] { return run_slice(reply, progress); });
  if (ran && progress == Progress::kMore) return true;
  if (ran && reply.more()) {
    done(ran);
  } else {
    end(ran, done);
  }
  return false;
}

void CastJob::push(exec::Slice slice) {
  if (batch_.size() <= kSmallCast) {
    services_.compute.enqueue_small(flow_, std::move(slice));
  } else {
    services_.compute.enqueue(flow_, std::move(slice));
  }
}

/// The admission is given back before the last reply is written: a client that is slow to read must
/// not hold up the others. `done` may delete this.
void CastJob::end(const Status& status, const Done& done) {
  drop_batch();
  done(status);
}

void CastJob::drop_batch() {
  admission_.release();
  segment_.reset();
  alarm_ = {};
}

Status CastJob::build() {
  const auto of_query = shard_of(query_, services_, snapshot_);
  if (!of_query) return of_query.error();
  const auto built = query_.shard ? scenegraph::query::build_shard(*snapshot_, *of_query, &stopped_)
                                  : scenegraph::build_all(*snapshot_, &stopped_);
  waiting_since_ = Clock::now();
  const bool out_of_time = has_budget_ && !cancelled_.load(std::memory_order_relaxed);
  if (!built && built.error().code == Code::kCancelled && out_of_time) return {};
  if (!built) return built.error();
  build_stats_ = *built;
  services_.metrics.count_build(metrics::BuildReason::kFull, built->trees_begun,
                                built->cells_expanded, built->build_seconds);
  return {};
}

Status CastJob::run_slice(v1::CastRaysResponse& reply, Progress& progress) {
  const auto begun = Clock::now();
  queued_ += begun - waiting_since_;
  if (cancelled_.load(std::memory_order_relaxed))
    return Error{Code::kCancelled, "cancelled while waiting", "CANCELLED"};
  if (!begun_) {
    if (Status ready = begin(); !ready) return ready;
  }
  if (Status traced = trace_slice(reply, progress); !traced) return traced;
  if (cancelled_.load(std::memory_order_relaxed))
    return Error{Code::kCancelled, "cancelled while tracing", "CANCELLED"};
  waiting_since_ = Clock::now();
  traced_ += waiting_since_ - begun;
  if (progress == Progress::kDone) describe(reply);
  return {};
}

/// Sets what is not a column: the revision and, in the last reply to a batch, what it cost.
void CastJob::describe(v1::CastRaysResponse& reply) {
  encode_revision(revision_, *reply.mutable_served());
  if (reply.more()) return reply.clear_stats();
  derived_.end();
  batch_time_ = Clock::now() - arrived_;
  services_.metrics.count_batch(query_.kind, stats_, batch_time_);
  stats_ += std::exchange(build_stats_, {});
  v1::CastStats& stats = *reply.mutable_stats();
  encode_stats(stats_, stats);
  stats.set_queue_us(microseconds(queued_));
  stats.set_trace_us(microseconds(traced_));
  total_stats_ += stats_;
  total_queued_ += queued_;
}

/// Runs on a worker: the query may be the first to need the revision's instances.
Status CastJob::begin() {
  if (query_.selects() && !selection_) {
    auto of_query = shard_of(query_, services_, snapshot_);
    if (!of_query) return of_query.error();
    auto selection = scenegraph::query::Selection::make(snapshot_, query_.root, query_.excluded,
                                                        query_.labels, *std::move(of_query));
    if (!selection) return selection.error();
    selection_.emplace(std::move(*selection));
  }
  traced_ = {};
  answered_ = 0;
  stats_ = {};
  if (query_.kind == scenegraph::QueryKind::kAll) {
    rays_.resize(batch_.size());
    batch_.decode(0, rays_);
    pager_.begin(rays_, admission_.first_list(),
                 replies_ == Replies::kOne ? kMaxHitsPerReply : kHitsPerPart);
  }
  begun_ = true;
  return {};
}

scenegraph::TraceOptions CastJob::options() const {
  // A full build is made before, on other workers.
  const bool full = query_.growth == scenegraph::Growth::kFull;
  return {.kind = query_.kind,
          .growth = full ? scenegraph::Growth::kFirstTouch : query_.growth,
          .surface = query_.surface,
          .points = query_.points,
          .culling = query_.culling,
          .selection = selection_ ? &*selection_ : nullptr,
          .max_hits = query_.max_hits,
          .cancelled = &stopped_,
          .partial = has_budget_};
}

Status CastJob::trace_slice(v1::CastRaysResponse& reply, Progress& progress) {
  reply.clear_first_ray();
  reply.clear_more();
  progress = Progress::kDone;
  if (query_.kind == scenegraph::QueryKind::kAll) {
    if (pager_.goes_on() && admission_.list_more(query_, batch_.size()))
      pager_.set_list_size(kFullList);
    Status made = pager_.next(*snapshot_, options(), query_.fields, reply);
    if (!reply.more()) stats_ += pager_.stats();
    return made;
  }
  if (answered_ == 0) begin_columns(reply);
  const std::size_t count = std::min(batch_.size() - answered_, rays_per_slice(query_));
  const auto traced = trace_rays(count, options(), reply);
  if (!traced) return traced.error();
  stats_ += *traced;
  take_over(count);
  if (answered_ < batch_.size()) progress = Progress::kMore;
  return {};
}

/// Gives the batch's columns their final size: all its rows, or those of a slice.
void CastJob::begin_columns(v1::CastRaysResponse& reply) {
  const std::size_t rows =
      query_.in_segment ? std::min(batch_.size(), rays_per_slice(query_)) : batch_.size();
  v1::CastRaysResponse& columns = columns_of(reply);
  resize_columns(query_.fields, rows, rows, columns);
  derived_.begin(*snapshot_, query_.points, columns, reply);
  sides_.begin(columns, query_, rows);
  if (query_.in_segment) reply.clear_columns();
  reply.clear_unanswered();
}

/// The rows of the next rays are made: copies them, if they go to a segment.
void CastJob::take_over(std::size_t count) {
  if (query_.in_segment) answer_.write(*segment_, answered_, count);
  answered_ += count;
}

/// Writes closest or any hits of the next rays to `hits`, and the columns that follow from them.
Result<scenegraph::TraceStats> CastJob::trace_hits(const accel::geometry::RayColumns& rays,
                                                   accel::geometry::HitColumns& hits,
                                                   const scenegraph::TraceOptions& options,
                                                   v1::CastRaysResponse& reply) {
  derived_.add_sources(hits);
  if (options.partial && !hits.state.is_asked()) {
    states_.resize(hits.size);
    hits.state = {states_.data()};
  }
  auto traced = scenegraph::trace(*snapshot_, rays, hits, options);
  if (!traced) return traced;
  if (traced->unanswered > 0) {
    const auto* states = static_cast<const accel::geometry::HitState*>(hits.state.data);
    mark_unanswered(std::span(states, hits.size), answered_, batch_.size(), reply);
  }
  if (const Status written = derived_.write(rays, hits, row()); !written) return written.error();
  return traced;
}

/// Writes the sides of the next points and, if other fields are asked, their nearest faces.
Result<scenegraph::TraceStats> CastJob::trace_with_sides(const accel::geometry::RayColumns& points,
                                                         accel::geometry::HitColumns& hits,
                                                         const scenegraph::TraceOptions& options,
                                                         v1::CastRaysResponse& reply) {
  scenegraph::TraceStats stats;
  if (!query_.sides_alone) {
    sides_.add_sources(hits);
    auto traced = trace_hits(points, hits, options, reply);
    if (!traced) return traced;
    stats = *traced;
  }
  auto found = sides_.write(*snapshot_, points, *query_.sides, options, hits, row());
  if (!found) return found;
  if (found->unanswered > 0) mark_unanswered(sides_.sides(), answered_, batch_.size(), reply);
  if (query_.sides_alone) return found;
  // A point is one, and has its answer when it has both.
  const std::uint64_t answered = std::min(stats.rays, found->rays);
  found->rays = found->invalid = found->unanswered = 0;
  stats += *found;
  stats.unanswered += stats.rays - answered;
  stats.rays = answered;
  return stats;
}

/// Writes the answers to the next rays into the reply.
Result<scenegraph::TraceStats> CastJob::trace_rays(std::size_t count,
                                                   const scenegraph::TraceOptions& options,
                                                   v1::CastRaysResponse& reply) {
  const accel::geometry::RayColumns rays = batch_.view(answered_, count, made_);
  if (query_.kind != scenegraph::QueryKind::kCount) {
    accel::geometry::HitColumns hits = view_hits(columns_of(reply), row(), count);
    if (query_.sides) return trace_with_sides(rays, hits, options, reply);
    return trace_hits(rays, hits, options, reply);
  }
  tallies_.resize(count);
  auto traced = scenegraph::count_hits(*snapshot_, rays, tallies_, options);
  if (traced) encode_tallies(tallies_, row(), columns_of(reply));
  if (traced && traced->unanswered > 0) mark_unanswered(tallies_, answered_, batch_.size(), reply);
  return traced;
}

std::shared_ptr<const scenegraph::revision::Snapshot> CastJob::let_go() {
  selection_.reset();
  scene_.reset();
  cut_.reset();
  return std::move(snapshot_);
}

void CastJob::rest() {
  if (batch_.size() <= kIdleRays && query_.kind != scenegraph::QueryKind::kAll) return;
  rays_ = {};
  made_ = {};
  tallies_ = {};
  states_ = {};
  derived_ = {};
  sides_ = {};
  answer_ = {};
  pager_ = {};
  if (is_sharded()) sharded_->rest();
}

std::string CastJob::slow_description() const {
  return fmt::format(
      "scene={} peer={} us={} rays={} queue_us={} trace_us={} cells={} trees={} "
      "build_us={}",
      flow_.scene, caller_.connection, microseconds(batch_time_), stats_.rays,
      microseconds(queued_), microseconds(traced_), stats_.cells_expanded, stats_.trees_begun,
      static_cast<std::uint64_t>(stats_.build_seconds * 1e6));
}

std::string CastJob::description() const {
  return fmt::format("scene={} peer={} rays={} queue_us={} cells={} trees={} build_us={}",
                     flow_.scene, caller_.connection, total_stats_.rays,
                     microseconds(total_queued_), total_stats_.cells_expanded,
                     total_stats_.trees_begun,
                     static_cast<std::uint64_t>(total_stats_.build_seconds * 1e6));
}

}  // namespace sightline::server::queries

// Batches that the servers of the shards trace: their questions are asked, and their answers
// merged.
#include <algorithm>
#include <bit>
#include <utility>

#include "scenegraph/query/selection.h"
#include "server/exec/rpc_status.h"
#include "server/queries/cast_job.h"
#include "server/shards/peers.h"
#include "server/shards/shard_cuts.h"

namespace sightline::server::queries {

using accel::geometry::Hit;
using accel::geometry::HitColumns;
using accel::geometry::HitState;
using accel::geometry::Ray;
using scenegraph::QueryKind;

template <class Request>
void CastJob::open_sharded(const Request& request) {
  sharded_ = std::make_unique<shards::ShardedCast>(
      services_.shard_peers, context_, request,
      shards::ShardedCast::Query{.kind = query_.kind,
                                 .surface = query_.surface,
                                 .max_hits = query_.max_hits,
                                 .allow_partial = query_.allow_partial,
                                 .sides = query_.sides,
                                 .sides_alone = query_.sides_alone});
}

template void CastJob::open_sharded(const v1::CastRaysRequest& request);
template void CastJob::open_sharded(const v1::QueryPointsRequest& request);

/// Begins a reply, or continues it when the peers have answered.
void CastJob::push_sharded(v1::CastRaysResponse& reply, const Done& done) {
  push([this, &reply, done] {
    bool asked = false;
    const Status ran = exec::to_status([&] { return run_sharded(reply, done, asked); });
    if (asked) return false;  // this may be gone
    if (ran && reply.more()) {
      done(ran);
    } else {
      end(ran, done);
    }
    return false;
  });
}

/// Sets `asked` if peers were asked: the reply continues when they have answered, and this may be
/// gone.
Status CastJob::run_sharded(v1::CastRaysResponse& reply, const Done& done, bool& asked) {
  queued_ += Clock::now() - waiting_since_;
  if (cancelled_.load(std::memory_order_relaxed))
    return Error{Code::kCancelled, "cancelled while waiting", "CANCELLED"};
  if (!begun_) {
    if (Status ready = begin_sharded(); !ready) return ready;
  }
  if (std::exchange(peers_asked_, true)) {
    if (Status taken = sharded_->take(); !taken) return taken;
  } else {
    sharded_->begin({.rays = std::span<const Ray>(rays_).subspan(answered_, sharded_part()),
                     .cut = cut_,
                     .revision = snapshot_->revision(),
                     .token = revision_.text(),
                     .budget_ends = has_budget_ ? std::optional(budget_ends_) : std::nullopt});
  }
  asked = sharded_->ask([this, &reply, done] {
    waiting_since_ = Clock::now();
    const Status pushed = exec::to_status([&] {
      push_sharded(reply, done);
      return Status();
    });
    if (!pushed) end(pushed, done);
  });
  if (asked) return {};
  peers_asked_ = false;
  return write_sharded(reply);
}

Status CastJob::begin_sharded() {
  using scenegraph::query::check_nodes;
  const std::span<const scenegraph::model::NodeId> roots(&query_.root, query_.root != 0 ? 1 : 0);
  if (Status known = check_nodes(*snapshot_, roots, "root"); !known) return known;
  if (Status known = check_nodes(*snapshot_, query_.excluded, "excluded"); !known) return known;
  sharded_since_ = Clock::now();
  cut_ = services_.shard_cuts.find_or_make(snapshot_, services_.shard_peers.size());
  rays_.resize(batch_.size());
  batch_.decode(0, rays_);
  traced_ = {};
  answered_ = 0;
  stats_ = {};
  peers_asked_ = false;
  begun_ = true;
  return {};
}

/// How many rays the next reply answers: those whose lists one message of a peer holds, too.
std::size_t CastJob::sharded_part() const {
  const std::size_t left = batch_.size() - answered_;
  if (query_.kind != QueryKind::kAll) return left;
  return std::min(left, std::max<std::size_t>(kMaxHitsPerReply / query_.max_hits, 1));
}

Status CastJob::write_sharded(v1::CastRaysResponse& reply) {
  const std::size_t part = sharded_part();
  stats_ += sharded_->stats();
  reply.clear_first_ray();
  reply.clear_more();
  reply.clear_unanswered();
  if (query_.kind == QueryKind::kAll) {
    if (Status written = write_sharded_lists(reply); !written) return written;
  } else {
    resize_columns(query_.fields, part, part, reply);
    if (Status written = write_sharded_hits(reply); !written) return written;
  }
  answered_ += part;
  reply.set_more(answered_ < batch_.size());
  traced_ = Clock::now() - sharded_since_;
  describe(reply);
  return {};
}

Status CastJob::write_sharded_hits(v1::CastRaysResponse& reply) {
  const scenegraph::query::ShardMerge& answers = sharded_->answers();
  derived_.begin(*snapshot_, query_.points, reply, reply);
  if (query_.kind == QueryKind::kCount) {
    encode_tallies(answers.tallies(), 0, reply);
    mark_unanswered(answers.tallies(), 0, batch_.size(), reply);
    return {};
  }
  HitColumns hits = view_hits(reply, 0, batch_.size());
  derived_.add_sources(hits);
  sides_.begin(reply, query_, batch_.size());
  sides_.add_sources(hits);
  if (query_.sides_alone) {
    write_sharded_sides(hits, reply);
    return {};
  }
  if (hits.bits != nullptr)
    std::fill_n(hits.bits, (hits.size + kRaysPerBitsByte - 1) / kRaysPerBitsByte, std::uint8_t{0});
  std::vector<HitState> states;
  states.reserve(hits.size);
  for (std::size_t i = 0; i < hits.size; ++i) {
    Hit hit = answers.hits()[i];
    // By normals, nearest faces were asked for at any distance.
    if (query_.sides && hit.t > rays_[i].tmax) {
      const std::uint32_t work = hit.work;
      hit = {};
      hit.work = work;
    }
    hits.set(i, hit);
    states.push_back(hit.state);
  }
  mark_unanswered(states, 0, batch_.size(), reply);
  if (query_.sides) {
    stats_.hits = static_cast<std::uint64_t>(std::ranges::count(states, HitState::kHit));
    write_sharded_sides(hits, reply);
  }
  return derived_.write(accel::geometry::columns_of(std::span<const Ray>(rays_)), hits, 0);
}

/// Writes the sides, and counts points: one has its answer when it has its side and, if that is
/// asked, its nearest face.
void CastJob::write_sharded_sides(const HitColumns& hits, v1::CastRaysResponse& reply) {
  const scenegraph::query::ShardSides& answers = sharded_->sides();
  sides_.write(answers.sides(), answers.votes(), hits, 0);
  mark_unanswered(answers.sides(), 0, batch_.size(), reply);
  if (query_.sides_alone) stats_.hits = 0;
  stats_.invalid =
      static_cast<std::uint64_t>(std::ranges::count(answers.sides(), scenegraph::Side::kInvalid));
  stats_.unanswered = 0;
  for (const char byte : reply.unanswered())
    stats_.unanswered +=
        static_cast<std::uint64_t>(std::popcount(static_cast<unsigned char>(byte)));
  stats_.rays = batch_.size() - stats_.unanswered;
}

Status CastJob::write_sharded_lists(v1::CastRaysResponse& reply) {
  const scenegraph::query::ShardMerge& answers = sharded_->answers();
  encode_lists(answers.tallies(), answers.listed(), query_.fields, reply);
  mark_unanswered(answers.tallies(), 0, answers.tallies().size(), reply);
  derived_.begin(*snapshot_, query_.points, reply, reply);
  reply.set_first_ray(answered_);
  return derived_.write_lists(std::span<const Ray>(rays_).subspan(answered_, sharded_part()),
                              answers.tallies(), answers.listed());
}

}  // namespace sightline::server::queries

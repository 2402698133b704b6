// Serves batches of rays: decode, admit, trace, encode.
#include "server/queries/cast_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "server/queries/query_codec.h"
#include "server/scenes/names.h"

namespace sightline::server::queries {
namespace {

/// Bytes of a reply with every field.
constexpr std::size_t kReplyBytesPerRay = 48;

std::uint64_t microseconds(std::chrono::steady_clock::duration time) {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(time).count());
}

}  // namespace

Status CastJob::open(const v1::CastRaysRequest& request) {
  if (Status good = scenes::check_scene_name(request.scene()); !good) return good;
  auto query = decode_query(request, services_.policy);
  if (!query) return query.error();
  auto scene = services_.scenes.get(request.scene());
  if (!scene) return scene.error();
  query_ = std::move(*query);
  scene_ = std::move(*scene);
  return {};
}

void CastJob::pin(std::shared_ptr<const scenegraph::revision::Snapshot> snapshot) {
  revision_ = scene_->token(snapshot->revision());
  snapshot_ = std::move(snapshot);
  scene_.reset();
}

Status CastJob::accept(const v1::Rays& rays) {
  if (Status decoded = decode_rays(rays, rays_); !decoded) return decoded;
  const bool lists = query_.kind == scenegraph::QueryKind::kAll;
  if (lists && replies_ == Replies::kOne && rays_.size() * query_.max_hits > kMaxHitsPerReply) {
    return Error{Code::kInvalidArgument,
                 fmt::format("{} rays with up to {} hits each are {} hits, the limit of "
                             "one reply "
                             "is {}; send fewer, lower max_hits or use StreamCastRays",
                             rays_.size(), query_.max_hits, rays_.size() * query_.max_hits,
                             kMaxHitsPerReply),
                 "TOO_MANY_HITS"};
  }
  const std::size_t bytes_per_ray =
      sizeof(accel::geometry::Ray) + sizeof(accel::geometry::Hit) + kReplyBytesPerRay;
  std::size_t bytes = rays.ByteSizeLong() + rays_.size() * bytes_per_ray;
  if (lists) {
    bytes += hit_pager_bytes(rays_.size(), query_.max_hits, services_.compute.threads());
    auto all_hits = services_.all_hits_admission.admit(rays_.size(), bytes);
    if (!all_hits) return all_hits.error();
    all_hits_ticket_ = std::move(*all_hits);
  }
  auto ticket = services_.admission.admit(rays_.size(), bytes);
  if (!ticket && rays_.size() <= kSmallCast) {
    if (auto reserve = services_.small_admission.admit(rays_.size(), bytes))
      ticket = std::move(reserve);
  }
  if (!ticket) return ticket.error();
  ticket_ = std::move(*ticket);
  accepted_ = Clock::now();
  begun_ = false;
  return {};
}

Status CastJob::run(v1::CastRaysResponse& reply) {
  // Given back before the last reply is written: a client that is slow to read must not hold up
  // the others.
  exec::Admission::Ticket ticket = std::move(ticket_), all_hits = std::move(all_hits_ticket_);
  const auto begun = Clock::now();
  if (Status selected = select(); !selected) return selected;
  const scenegraph::TraceOptions options{.kind = query_.kind,
                                         .growth = query_.growth,
                                         .surface = query_.surface,
                                         .culling = query_.culling,
                                         .selection = selection_ ? &*selection_ : nullptr,
                                         .max_hits = query_.max_hits,
                                         .cancelled = &cancelled_};
  if (!begun_) {
    queued_ = begun - accepted_;
    traced_ = {};
    if (query_.kind == scenegraph::QueryKind::kAll) pager_.begin(rays_);
    begun_ = true;
  }
  if (Status answered = answer(options, reply); !answered) return answered;
  traced_ += Clock::now() - begun;
  encode_revision(revision_, *reply.mutable_served());
  if (reply.more()) {
    ticket_ = std::move(ticket);
    all_hits_ticket_ = std::move(all_hits);
    reply.clear_stats();
    return {};
  }
  v1::CastStats& stats = *reply.mutable_stats();
  encode_stats(stats_, stats);
  stats.set_queue_us(microseconds(queued_));
  stats.set_trace_us(microseconds(traced_));
  return {};
}

/// On a worker, as it may be the first to need the revision's instances.
Status CastJob::select() {
  if (!query_.selects() || selection_) return {};
  auto selection = scenegraph::query::Selection::make(snapshot_, query_.root, query_.excluded);
  if (!selection) return selection.error();
  selection_.emplace(std::move(*selection));
  return {};
}

Status CastJob::answer(const scenegraph::TraceOptions& options, v1::CastRaysResponse& reply) {
  reply.clear_first_ray();
  reply.clear_more();
  if (query_.kind == scenegraph::QueryKind::kAll) {
    Status made = pager_.next(*snapshot_, options, query_.fields, reply);
    stats_ = pager_.stats();
    return made;
  }
  if (query_.kind == scenegraph::QueryKind::kCount) {
    tallies_.resize(rays_.size());
    const auto counted = scenegraph::count_hits(*snapshot_, rays_, tallies_, options);
    if (!counted) return counted.error();
    encode_tallies(tallies_, {}, query_.fields, reply);
    stats_ = *counted;
    return {};
  }
  hits_.resize(rays_.size());
  const auto traced = scenegraph::trace(*snapshot_, rays_, hits_, options);
  if (!traced) return traced.error();
  encode_hits(hits_, query_.fields, reply);
  stats_ = *traced;
  return {};
}

void CastJob::close() {
  selection_.reset();
  scene_.reset();
  snapshot_.reset();
}

std::size_t hit_pager_bytes(std::size_t rays, std::size_t max_hits, int threads) {
  const std::size_t overshoot = static_cast<std::size_t>(threads) * scenegraph::kHitsPerListBlock;
  const std::size_t hits = std::min(rays * max_hits, kHitsListed + overshoot);
  return rays * sizeof(scenegraph::RayTally) + 2 * hits * sizeof(accel::geometry::Hit);
}

void HitPager::begin(std::span<const accel::geometry::Ray> rays) {
  rays_ = rays;
  sent_ = listed_ = sent_hits_ = 0;
  tallies_.resize(rays.size());
  hits_.clear();
  stats_ = {};
}

Status HitPager::list(const scenegraph::revision::Snapshot& snapshot,
                      scenegraph::TraceOptions options) {
  options.hits_at_once = kHitsListed;
  const auto traced = scenegraph::list_hits(snapshot, rays_.subspan(listed_),
                                            std::span(tallies_).subspan(listed_), hits_, options);
  if (!traced) return traced.error();
  listed_ += traced->rays;
  sent_hits_ = 0;
  stats_ += *traced;
  return {};
}

Status HitPager::next(const scenegraph::revision::Snapshot& snapshot,
                      const scenegraph::TraceOptions& options, std::span<const v1::HitField> fields,
                      v1::CastRaysResponse& reply) {
  if (sent_ == listed_) {
    if (Status done = list(snapshot, options); !done) return done;
  }
  const std::size_t first = sent_;
  std::size_t count = 0;
  for (; sent_ < listed_ && count + tallies_[sent_].count <= kMaxHitsPerReply; ++sent_)
    count += tallies_[sent_].count;
  encode_tallies(std::span(tallies_).subspan(first, sent_ - first),
                 std::span(hits_).subspan(sent_hits_, count), fields, reply);
  sent_hits_ += count;
  reply.set_first_ray(first);
  reply.set_more(sent_ < rays_.size());
  if (!reply.more()) hits_ = {};  // frees the memory while the stream is idle
  return {};
}

}  // namespace sightline::server::queries

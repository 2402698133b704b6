// Lists the hits of a batch in parts that fit a reply.
#include "server/queries/hit_pager.h"

#include <algorithm>

namespace sightline::server::queries {

std::size_t hit_pager_bytes(std::size_t rays, std::size_t max_hits, int threads,
                            const ListSize& size) {
  const std::size_t overshoot =
      static_cast<std::size_t>(threads) * std::max(size.of_block, max_hits);
  const std::size_t hits = std::min(rays * max_hits, size.hits + overshoot);
  return rays * sizeof(scenegraph::RayTally) + 2 * hits * sizeof(accel::geometry::Hit);
}

void HitPager::begin(std::span<const accel::geometry::Ray> rays, const ListSize& size) {
  rays_ = rays;
  size_ = size;
  sent_ = listed_ = sent_hits_ = 0;
  tallies_.resize(rays.size());
  hits_.clear();
  stats_ = {};
}

Status HitPager::list(const scenegraph::revision::Snapshot& snapshot,
                      scenegraph::TraceOptions options) {
  options.hits_at_once = size_.hits;
  options.hits_per_block = size_.of_block;
  const auto traced = scenegraph::list_hits(snapshot, rays_.subspan(listed_),
                                            std::span(tallies_).subspan(listed_), hits_, options);
  if (!traced) return traced.error();
  listed_ += traced->rays + traced->unanswered;
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
  const std::span tallies =
      std::span<const scenegraph::RayTally>(tallies_).subspan(first, sent_ - first);
  const std::span hits = std::span<const accel::geometry::Hit>(hits_).subspan(sent_hits_, count);
  encode_lists(tallies, hits, fields, reply);
  reply.clear_unanswered();
  if (stats_.unanswered > 0) mark_unanswered(tallies, 0, tallies.size(), reply);
  derived_.begin(snapshot, reply);
  Status derived = derived_.write_lists(rays_.subspan(first, sent_ - first), tallies, hits);
  if (!derived) return derived;
  sent_hits_ += count;
  reply.set_first_ray(first);
  reply.set_more(sent_ < rays_.size());
  if (!reply.more()) {  // frees the memory while the stream is idle
    hits_ = {};
    derived_.end();
  }
  return {};
}

}  // namespace sightline::server::queries

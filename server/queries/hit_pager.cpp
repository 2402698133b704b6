// Lists the hits of a batch in parts that fit a reply.
#include "server/queries/hit_pager.h"

#include <algorithm>

namespace sightline::server::queries {

std::size_t hit_pager_bytes(std::size_t rays, std::size_t max_hits, int threads,
                            const ListSize& size) {
  const std::size_t overshoot =
      static_cast<std::size_t>(threads) * std::max(size.of_block, max_hits);
  const std::size_t hits = std::min(rays * max_hits, size.hits + overshoot);
  const std::size_t waiting = std::min(rays * max_hits, std::max(kHitsPerPart, max_hits));
  return rays * sizeof(scenegraph::RayTally) + (2 * hits + waiting) * sizeof(accel::geometry::Hit);
}

void HitPager::begin(std::span<const accel::geometry::Ray> rays, const ListSize& size,
                     std::size_t part_hits) {
  rays_ = rays;
  size_ = size;
  part_hits_ = part_hits;
  sent_ = listed_ = sent_hits_ = 0;
  tallies_.resize(rays.size());
  hits_.clear();
  stats_ = {};
}

Status HitPager::list(const scenegraph::revision::Snapshot& snapshot,
                      scenegraph::TraceOptions options) {
  options.hits_at_once = size_.hits;
  options.hits_per_block = size_.of_block;
  hits_.erase(hits_.begin(), hits_.begin() + static_cast<std::ptrdiff_t>(sent_hits_));
  sent_hits_ = 0;
  std::vector<accel::geometry::Hit> more;
  const auto traced = scenegraph::list_hits(snapshot, rays_.subspan(listed_),
                                            std::span(tallies_).subspan(listed_), more, options);
  if (!traced) return traced.error();
  hits_.insert(hits_.end(), more.begin(), more.end());
  listed_ += traced->rays + traced->unanswered;
  stats_ += *traced;
  return {};
}

Status HitPager::next(const scenegraph::revision::Snapshot& snapshot,
                      const scenegraph::TraceOptions& options, std::span<const v1::HitField> fields,
                      v1::CastRaysResponse& reply) {
  const std::size_t first = sent_;
  std::size_t count = 0;
  const auto fits = [&] { return sent_ == first || count + tallies_[sent_].count <= part_hits_; };
  for (;;) {
    for (; sent_ < listed_ && fits(); ++sent_) count += tallies_[sent_].count;
    if (sent_ < listed_ || listed_ == rays_.size()) break;
    if (Status done = list(snapshot, options); !done) return done;
  }
  const std::span tallies =
      std::span<const scenegraph::RayTally>(tallies_).subspan(first, sent_ - first);
  const std::span hits = std::span<const accel::geometry::Hit>(hits_).subspan(sent_hits_, count);
  encode_lists(tallies, hits, fields, reply);
  reply.clear_unanswered();
  if (stats_.unanswered > 0) mark_unanswered(tallies, 0, tallies.size(), reply);
  derived_.begin(snapshot, options.points, reply, reply);
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

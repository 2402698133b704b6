// Prefetches that the servers of the shards do: they build, or cast the rays.
#include <algorithm>
#include <utility>

#include "scenegraph/query/selection.h"
#include "server/queries/prefetch_job.h"
#include "server/shards/peers.h"
#include "server/shards/shard_cuts.h"

namespace sightline::server::queries {

using accel::geometry::Ray;

Status PrefetchJob::ask(std::function<void()> answered, bool& asked) {
  if (cancelled_.load(std::memory_order_relaxed))
    return Error{Code::kCancelled, "cancelled while building", "CANCELLED"};
  if (!peers_asked_) {
    using scenegraph::query::check_nodes;
    if (Status known = check_nodes(*snapshot_, roots_, "root"); !known) return known;
    if (Status known = check_nodes(*snapshot_, query_.excluded, "excluded"); !known) return known;
  }
  return has_rays_ ? ask_for_rays(answered, asked) : ask_for_trees(std::move(answered), asked);
}

Status PrefetchJob::ask_for_trees(std::function<void()> answered, bool& asked) {
  if (std::exchange(peers_asked_, true)) return trees_of_shards_.take();
  asked = true;
  trees_of_shards_.start(asked_for_trees_, std::move(answered));
  return {};
}

/// Casts the rays to build what they meet; the answer is not read.
Status PrefetchJob::ask_for_rays(const std::function<void()>& answered, bool& asked) {
  if (cut_ == nullptr)
    cut_ = services_.shard_cuts.find_or_make(snapshot_, services_.shard_peers.size());
  for (;;) {
    if (std::exchange(peers_asked_, true)) {
      if (Status taken = cast_->take(); !taken) return taken;
    } else {
      cast_->begin({.rays = next_rays(),
                    .cut = cut_,
                    .revision = snapshot_->revision(),
                    .token = revision_.text()});
    }
    asked = cast_->ask(answered);
    if (asked) return {};
    peers_asked_ = false;
    const scenegraph::TraceStats stats = cast_->stats();
    progress_.add(stats.cells_expanded, stats.build_seconds);
    progress_.rays_done += next_rays().size();
    if (progress_.rays_done == rays_.size()) return {};
  }
}

std::span<const Ray> PrefetchJob::next_rays() const {
  const auto left = std::span<const Ray>(rays_).subspan(progress_.rays_done);
  return left.first(std::min(left.size(), kRaysOfPart));
}

}  // namespace sightline::server::queries

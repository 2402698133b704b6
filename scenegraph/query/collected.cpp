#include "scenegraph/query/collected.h"

#include <algorithm>

namespace sightline::scenegraph::query {

accel::wide::HitSink Collected::begin(QueryKind kind) {
  list_.clear();
  primitives_.clear();
  flat_primitives_.clear();
  entered_.clear();
  counted_ = 0;
  return {.list = kind == QueryKind::kAll ? &list_ : nullptr,
          .primitives = kind == QueryKind::kCount ? &primitives_ : nullptr};
}

std::uint32_t Collected::count(TraceStats& stats) {
  const std::uint64_t all = counted_ + flat_primitives_.sorted().size();
  stats.hits_found += all;
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(all, kMaxCount));
}

std::span<const accel::wide::ListedHit> Collected::list(TraceStats& stats, bool& cut_off) {
  std::span<const accel::wide::ListedHit> hits = list_.sorted();
  cut_off = hits.size() > max_hits_;
  if (cut_off) {
    hits = hits.first(max_hits_);
    ++stats.cut_off;
  }
  stats.hits_found += hits.size();
  return hits;
}

}  // namespace sightline::scenegraph::query

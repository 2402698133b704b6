#include "scenegraph/query/collected.h"

#include <algorithm>

namespace sightline::scenegraph::query {

accel::mesh::HitSinks Collected::begin(QueryKind kind) {
  list_.clear();
  entered_.clear();
  counted_ = 0;
  return {.list = kind == QueryKind::kAll ? &list_ : nullptr,
          .primitives = kind == QueryKind::kCount ? &primitives_ : nullptr};
}

RayTally Collected::count(TraceStats& stats) const {
  stats.hits_found += counted_;
  return {.count = static_cast<std::uint32_t>(std::min<std::uint64_t>(counted_, kMaxCount))};
}

RayTally Collected::list(TraceStats& stats, std::span<const accel::mesh::ListedHit>& hits) {
  hits = list_.sorted();
  const bool cut_off = hits.size() > max_hits_;
  if (cut_off) {
    hits = hits.first(max_hits_);
    ++stats.cut_off;
  }
  stats.hits_found += hits.size();
  return {.count = static_cast<std::uint32_t>(hits.size()), .cut_off = cut_off};
}

}  // namespace sightline::scenegraph::query

// Asks the shards of a scene, and merges their answers.
#include "scenegraph/query/shard_merge.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <tuple>
#include <utility>

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::kWorkDeferred;
using accel::geometry::Ray;

auto order_of(const Hit& hit) { return std::tie(hit.t, hit.node, hit.primitive); }

std::uint32_t sum_of_work(std::uint32_t a, std::uint32_t b) {
  constexpr std::uint32_t kMost = kWorkDeferred - 1;
  const std::uint32_t x = a & kMost, y = b & kMost;
  return std::min(kMost - x, y) + x + ((a | b) & kWorkDeferred);
}

}  // namespace

std::vector<ShardQuestion> with_rays(std::vector<ShardQuestion> by_shard) {
  for (std::uint32_t shard = 0; shard < by_shard.size(); ++shard) by_shard[shard].shard = shard;
  std::erase_if(by_shard, [](const ShardQuestion& q) { return q.rays.empty(); });
  return by_shard;
}

void ShardMerge::begin(const ShardCut& cut, QueryKind kind, std::span<const Ray> rays,
                       std::uint32_t max_hits, bool points) {
  cut_ = &cut;
  points_ = points;
  kind_ = kind;
  max_hits_ = max_hits;
  rays_ = rays;
  order_.clear();
  ways_.assign(rays.size(), {});
  lost_.assign(rays.size(), 0);
  hits_.assign(one_by_one() ? rays.size() : 0, {});
  tallies_.assign(one_by_one() ? 0 : rays.size(), {});
  lists_.clear();
  listed_.clear();
  stats_ = {};
  finished_ = false;
  ShardRay shard_ray(cut, points_);
  for (std::uint32_t i = 0; i < rays.size(); ++i) {
    if (!shard_ray.begin(rays[i])) {
      set_invalid(i);
      continue;
    }
    const std::vector<std::uint8_t>& shards = shard_ray.by_entry();
    ways_[i].next = static_cast<std::uint32_t>(order_.size());
    order_.insert(order_.end(), shards.begin(), shards.end());
    ways_[i].end = static_cast<std::uint32_t>(order_.size());
  }
}

void ShardMerge::set_invalid(std::uint32_t ray) {
  ++stats_.invalid;
  if (one_by_one()) {
    hits_[ray].t = std::numeric_limits<double>::quiet_NaN();
    hits_[ray].state = HitState::kInvalid;
  } else {
    tallies_[ray].count = kind_ == QueryKind::kCount ? kInvalidCount : 0;
    tallies_[ray].state = HitState::kInvalid;
  }
}

std::vector<ShardQuestion> ShardMerge::next() {
  std::vector<ShardQuestion> questions(cut_->size());
  ShardRay shard_ray(*cut_, points_);
  for (std::uint32_t i = 0; i < rays_.size(); ++i) {
    Way& way = ways_[i];
    if (way.next == way.end) continue;
    if (!one_by_one()) {
      for (; way.next < way.end; ++way.next) questions[order_[way.next]].rays.push_back(i);
      continue;
    }
    const Hit& best = hits_[i];
    if (best.state == HitState::kHit) {
      // A shard that may have a hit at the same t is asked, too: its node or primitive may come
      // first.
      shard_ray.begin(rays_[i]);
      while (way.next < way.end &&
             (kind_ == QueryKind::kAny || !shard_ray.may_meet(order_[way.next], best.t)))
        ++way.next;
    }
    if (way.next < way.end) questions[order_[way.next++]].rays.push_back(i);
  }
  questions = with_rays(std::move(questions));
  if (questions.empty() && !finished_) finish();
  return questions;
}

Ray ShardMerge::limited(std::uint32_t ray) const {
  Ray limited = rays_[ray];
  if (kind_ == QueryKind::kClosest && hits_[ray].state == HitState::kHit)
    limited.tmax = std::min(limited.tmax, hits_[ray].t);
  return limited;
}

void ShardMerge::take(const ShardQuestion& question, std::span<const Hit> hits) {
  assert(one_by_one() && hits.size() == question.rays.size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const std::uint32_t ray = question.rays[i];
    Hit& best = hits_[ray];
    const std::uint32_t work = sum_of_work(best.work, hits[i].work);
    if (hits[i].state == HitState::kUnanswered) lost_[ray] = 1;
    if (hits[i].state == HitState::kHit &&
        (best.state != HitState::kHit || order_of(hits[i]) < order_of(best)))
      best = hits[i];
    best.work = work;
    // A closest hit that is not known to be the closest is none.
    if (lost_[ray] != 0 && kind_ == QueryKind::kClosest) ways_[ray].next = ways_[ray].end;
  }
}

void ShardMerge::take(const ShardQuestion& question, std::span<const RayTally> tallies,
                      std::span<const Hit> listed) {
  assert(!one_by_one() && tallies.size() == question.rays.size());
  for (std::size_t i = 0; i < tallies.size(); ++i) {
    const std::uint32_t ray = question.rays[i];
    RayTally& sum = tallies_[ray];
    sum.work = sum_of_work(sum.work, tallies[i].work);
    sum.cut_off |= tallies[i].cut_off;
    if (tallies[i].state == HitState::kUnanswered) {
      lost_[ray] = 1;
    } else if (tallies[i].count > 0) {
      sum.count = std::min(kMaxCount - sum.count, tallies[i].count) + sum.count;
      sum.state = HitState::kHit;
    }
  }
  if (kind_ != QueryKind::kAll) return;
  lists_.push_back(
      {question.rays, {tallies.begin(), tallies.end()}, {listed.begin(), listed.end()}});
}

void ShardMerge::lose(const ShardQuestion& question) {
  for (const std::uint32_t ray : question.rays) {
    lost_[ray] = 1;
    if (kind_ == QueryKind::kClosest) ways_[ray].next = ways_[ray].end;
  }
}

void ShardMerge::finish() {
  finished_ = true;
  set_unanswered();
  if (kind_ == QueryKind::kAll) merge_lists();
  stats_.rays = rays_.size() - stats_.unanswered;
  for (const Hit& hit : hits_) stats_.hits += hit.state == HitState::kHit ? 1u : 0u;
  for (const RayTally& tally : tallies_) {
    if (tally.state != HitState::kHit) continue;
    ++stats_.hits;
    stats_.hits_found += tally.count;
    stats_.cut_off += tally.cut_off ? 1u : 0u;
  }
}

void ShardMerge::set_unanswered() {
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    const bool found = kind_ == QueryKind::kAny && hits_[i].state == HitState::kHit;
    if (lost_[i] == 0 || found) continue;
    ++stats_.unanswered;
    if (one_by_one()) {
      hits_[i] = {};
      hits_[i].t = -accel::geometry::kInfinity;
      hits_[i].state = HitState::kUnanswered;
    } else {
      tallies_[i] = {.count = kind_ == QueryKind::kCount ? kUnansweredCount : 0,
                     .state = HitState::kUnanswered};
    }
  }
}

void ShardMerge::merge_lists() {
  struct Cursor {
    std::size_t row = 0, hit = 0;
  };
  std::vector<Cursor> cursors(lists_.size());
  for (std::uint32_t ray = 0; ray < rays_.size(); ++ray) {
    const std::size_t first = listed_.size();
    RayTally& tally = tallies_[ray];
    for (std::size_t i = 0; i < lists_.size(); ++i) {
      const Lists& lists = lists_[i];
      Cursor& at = cursors[i];
      if (at.row == lists.rays.size() || lists.rays[at.row] != ray) continue;
      const auto begin = lists.hits.begin() + static_cast<std::ptrdiff_t>(at.hit);
      const std::uint32_t count = lists.tallies[at.row++].count;
      at.hit += count;
      if (tally.state == HitState::kHit) listed_.insert(listed_.end(), begin, begin + count);
    }
    const auto own = listed_.begin() + static_cast<std::ptrdiff_t>(first);
    std::sort(own, listed_.end(),
              [](const Hit& a, const Hit& b) { return order_of(a) < order_of(b); });
    if (tally.count > max_hits_) {
      tally.count = max_hits_;
      tally.cut_off = true;
      listed_.resize(first + max_hits_);
    }
  }
  lists_ = {};
}

}  // namespace sightline::scenegraph::query

// Asks the shards of a scene for crossings or sides, and adds up or keeps what they answer.
#include "scenegraph/query/shard_sides.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace sightline::scenegraph::query {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;

void ShardSides::begin(const ShardCut& cut, const SideQuestion& question,
                       std::span<const Ray> points, std::span<const Hit> nearest) {
  cut_ = &cut;
  question_ = question;
  points_ = points;
  nearest_ = nearest;
  assert(!by_normal() || nearest.size() == points.size());
  sides_.assign(points.size(), Side::kOutside);
  votes_.assign(points.size(), 0);
  first_ = end_ = 0;
}

std::vector<ShardQuestion> ShardSides::next() {
  ShardRay ray(*cut_, /*points=*/false);
  for (;;) {
    end_part();
    if (end_ == points_.size()) return {};
    begin_part();
    std::vector<ShardQuestion> by_shard(cut_->size());
    for (std::size_t i = first_; i < end_; ++i) {
      const auto point = static_cast<std::uint32_t>(i);
      if (by_normal()) {
        ask_for_side(point, by_shard);
      } else {
        ask_for_crossings(point, ray, by_shard);
      }
    }
    by_shard = with_rays(std::move(by_shard));
    if (!by_shard.empty()) return by_shard;
  }
}

void ShardSides::begin_part() {
  const std::size_t left = points_.size() - end_;
  end_ += by_normal() ? left : std::min(left, kMaxCrossings / question_.rays);
  crossings_.assign(by_normal() ? 0 : (end_ - first_) * question_.rays, 0);
}

/// Decides the points that were asked for.
void ShardSides::end_part() {
  if (!by_normal()) {
    for (std::size_t i = first_; i < end_; ++i) {
      if (sides_[i] != Side::kOutside) continue;
      const auto own = std::span(crossings_).subspan((i - first_) * question_.rays, question_.rays);
      const auto votes = std::ranges::count_if(
          own, [&](std::uint32_t crossings) { return says_inside(question_.rule, crossings); });
      votes_[i] = static_cast<std::uint8_t>(votes);
      sides_[i] = majority(votes_[i], question_.rays);
    }
  }
  first_ = end_;
  if (end_ == points_.size()) crossings_ = {};
}

/// Asks the shard that has the point's nearest face.
void ShardSides::ask_for_side(std::uint32_t point, std::vector<ShardQuestion>& by_shard) {
  const Hit& nearest = nearest_[point];
  if (nearest.state == HitState::kInvalid) sides_[point] = Side::kInvalid;
  if (nearest.state == HitState::kUnanswered) sides_[point] = Side::kUnanswered;
  if (nearest.state != HitState::kHit) return;
  const std::uint32_t shard = cut_->shard_of(nearest.node);
  if (shard < by_shard.size()) {
    by_shard[shard].rays.push_back(point);
  } else {
    sides_[point] = Side::kUnanswered;  // no node that rays can meet
  }
}

/// Asks the shards that one of the point's rays may meet.
void ShardSides::ask_for_crossings(std::uint32_t point, ShardRay& ray,
                                   std::vector<ShardQuestion>& by_shard) {
  Ray from_point = points_[point];
  if (std::isnan(from_point.tmax)) {
    sides_[point] = Side::kInvalid;
    return;
  }
  from_point.tmin = 0;
  from_point.tmax = accel::geometry::kInfinity;
  std::size_t asked = 0;
  for (std::uint32_t i = 0; i < question_.rays && asked < by_shard.size(); ++i) {
    from_point.direction = side_direction(i);
    if (!ray.begin(from_point)) {
      sides_[point] = Side::kInvalid;
      return;
    }
    for (std::uint32_t shard = 0; shard < by_shard.size(); ++shard) {
      std::vector<std::uint32_t>& points = by_shard[shard].rays;
      const bool is_asked = !points.empty() && points.back() == point;
      if (is_asked || !ray.may_meet(shard, from_point.tmax)) continue;
      points.push_back(point);
      ++asked;
    }
  }
}

void ShardSides::take(const ShardQuestion& question, std::span<const Side> sides,
                      std::span<const std::uint32_t> crossings) {
  const std::size_t rays = question_.rays;
  assert(sides.size() == question.rays.size());
  assert(by_normal() || crossings.size() == sides.size() * rays);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const std::uint32_t point = question.rays[i];
    if (by_normal() || sides[i] == Side::kUnanswered) {
      sides_[point] = sides[i];
      continue;
    }
    const std::size_t at = (point - first_) * rays;
    for (std::size_t ray = 0; ray < rays; ++ray) crossings_[at + ray] += crossings[i * rays + ray];
  }
}

void ShardSides::lose(const ShardQuestion& question) {
  for (const std::uint32_t point : question.rays) sides_[point] = Side::kUnanswered;
}

}  // namespace sightline::scenegraph::query

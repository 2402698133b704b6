// Counts what rays from points cross, from the point on exactly: many rays of one direction, which
// packets take together.
#include "scenegraph/sides.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "scenegraph/query/normal_sides.h"
#include "scenegraph/query/or_error.h"
#include "scenegraph/query/point_order.h"
#include "scenegraph/trace.h"

namespace sightline::scenegraph {
namespace {

using accel::geometry::Culling;
using accel::geometry::HitState;
using accel::geometry::RayColumns;
using accel::geometry::Vec3d;

Status check(const SideQuestion& question, const RayColumns& points, const SideAnswers& answers) {
  const std::uint32_t most = question.rule == SideRule::kNormal ? 1 : kMaxSideRays;
  if (question.rays % 2 == 0 || question.rays > most) {
    return Error{Code::kInvalidArgument,
                 std::to_string(question.rays) + " side rays: the number is odd, at most " +
                     std::to_string(most),
                 "SIDE_RAYS"};
  }
  const std::size_t votes = answers.votes.empty() ? points.size : answers.votes.size();
  const std::size_t all = question.rule == SideRule::kNormal ? 0 : points.size * question.rays;
  const std::size_t crossings = answers.crossings.empty() ? all : answers.crossings.size();
  if (answers.sides.size() == points.size && votes == points.size && crossings == all) return {};
  return Error{Code::kInvalidArgument,
               std::to_string(points.size) + " points, but room for " +
                   std::to_string(answers.sides.size()) + " sides, " + std::to_string(votes) +
                   " votes and " + std::to_string(crossings) + " crossings",
               "COUNT_MISMATCH"};
}

/// What the rays of the points have counted so far.
class Votes {
 public:
  Votes(const revision::Snapshot& snapshot, const RayColumns& points, const TraceOptions& options)
      : snapshot_(snapshot), rays_(points), options_(options), inside_(points.size) {
    rays_.tmin = accel::geometry::for_all(accel::geometry::kFromOrigin);
    rays_.tmax = accel::geometry::for_all(accel::geometry::kInfinity);
    options_.kind = QueryKind::kCount;
    options_.points = false;
    options_.from_origin = true;
  }

  /// Casts one ray from each point.
  Status cast(SideRule rule, const Vec3d& direction) {
    rays_.direction = {accel::geometry::for_all(direction.x), accel::geometry::for_all(direction.y),
                       accel::geometry::for_all(direction.z)};
    if (rule == SideRule::kParity) {
      if (Status counted = count(Culling::kNone, tallies_); !counted) return counted;
    } else {
      if (Status counted = count(Culling::kBack, tallies_); !counted) return counted;
      if (Status counted = count(Culling::kFront, backs_); !counted) return counted;
    }
    for (std::size_t i = 0; i < inside_.size(); ++i)
      inside_[i] += static_cast<std::uint8_t>(says_inside(rule, crossings(rule, i)));
    return {};
  }

  /// Of the last ray of a point.
  std::uint32_t crossings(SideRule rule, std::size_t point) const {
    const std::uint32_t met = tallies_[point].count;
    return rule == SideRule::kParity ? met : met - backs_[point].count;
  }

  Side side(std::size_t point, std::uint32_t rays) const {
    const HitState state = states_[point];
    if (state == HitState::kInvalid) return Side::kInvalid;
    if (state == HitState::kUnanswered) return Side::kUnanswered;
    return majority(inside_[point], rays);
  }
  std::uint8_t votes(std::size_t point) const { return inside_[point]; }
  const TraceStats& stats() const { return stats_; }

 private:
  Status count(Culling culling, std::vector<RayTally>& tallies) {
    options_.culling = culling;
    tallies.resize(rays_.size);
    const auto counted = count_hits(snapshot_, rays_, tallies, options_);
    if (!counted) return counted.error();
    stats_ += *counted;
    states_.resize(rays_.size, HitState::kMiss);
    for (std::size_t i = 0; i < rays_.size; ++i) {
      if (tallies[i].state != HitState::kHit) states_[i] = std::max(states_[i], tallies[i].state);
    }
    return {};
  }

  const revision::Snapshot& snapshot_;
  RayColumns rays_;
  TraceOptions options_;
  std::vector<std::uint8_t> inside_;
  std::vector<RayTally> tallies_, backs_;
  std::vector<HitState> states_;
  TraceStats stats_;
};

Result<TraceStats> count_sides(const revision::Snapshot& snapshot, const RayColumns& points,
                               const SideQuestion& question, const SideAnswers& answers,
                               const TraceOptions& options) {
  const query::OrderedPoints ordered(points);
  Votes votes(snapshot, ordered.columns, options);
  const std::uint32_t rays = question.rays;
  for (std::uint32_t ray = 0; ray < rays; ++ray) {
    if (const Status cast = votes.cast(question.rule, side_direction(ray)); !cast)
      return cast.error();
    if (answers.crossings.empty()) continue;
    for (std::size_t i = 0; i < points.size; ++i)
      answers.crossings[std::size_t{ordered.order[i]} * rays + ray] =
          votes.crossings(question.rule, i);
  }
  for (std::size_t i = 0; i < points.size; ++i) {
    const std::size_t at = ordered.order[i];
    const Side side = std::isnan(points.tmax[at]) ? Side::kInvalid : votes.side(i, rays);
    answers.sides[at] = side;
    const bool answered = side == Side::kInside || side == Side::kOutside;
    if (!answers.votes.empty()) answers.votes[at] = answered ? votes.votes(i) : 0;
    if (!answers.crossings.empty() && !answered)
      std::ranges::fill(answers.crossings.subspan(at * rays, rays), 0u);
  }
  return votes.stats();
}

/// The stats of rays as those of points.
TraceStats of_points(TraceStats stats, std::span<const Side> sides) {
  const auto count = [&](Side side) {
    return static_cast<std::uint64_t>(std::count(sides.begin(), sides.end(), side));
  };
  stats.invalid = count(Side::kInvalid);
  stats.unanswered = count(Side::kUnanswered);
  stats.rays = sides.size() - stats.unanswered;
  stats.hits = stats.hits_found = stats.cut_off = 0;
  return stats;
}

}  // namespace

Result<TraceStats> find_sides(const revision::Snapshot& snapshot, const RayColumns& points,
                              const SideQuestion& question, const SideAnswers& answers,
                              const TraceOptions& options) {
  if (const Status good = check(question, points, answers); !good) return good.error();
  const auto found = query::or_error([&] {
    if (question.rule == SideRule::kNormal)
      return query::sides_by_normal(snapshot, points, answers.sides, options);
    return count_sides(snapshot, points, question, answers, options);
  });
  if (!found) return found.error();
  return of_points(*found, answers.sides);
}

}  // namespace sightline::scenegraph

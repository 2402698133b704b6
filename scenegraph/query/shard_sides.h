// The sides of one batch of points answered by the shards of a scene: which points each shard is
// asked for, and the answers of all shards as one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/geometry/ray.h"
#include "scenegraph/query/shard_cut.h"
#include "scenegraph/query/shard_merge.h"
#include "scenegraph/side_rule.h"

namespace sightline::scenegraph::query {

/// Most crossings in an answer of a shard: points times rays.
inline constexpr std::size_t kMaxCrossings = std::size_t{1} << 18;

/// Merges the sides that shards answer. After begin(), call next() until it returns nothing; each
/// of its questions is answered by take() or lose(). By parity and by winding, the shards that a
/// point's rays may meet are asked for crossings, at most kMaxCrossings at a time. By normals, the
/// shard that has the nearest face is asked for the side. The answers are those of find_sides() to
/// the whole scene. Threads: one at a time.
class ShardSides {
 public:
  /// The cut and the points must not change until the batch is done. `nearest`: for kNormal, the
  /// nearest face of each point in the whole scene, at any distance.
  void begin(const ShardCut& cut, const SideQuestion& question,
             std::span<const accel::geometry::Ray> points,
             std::span<const accel::geometry::Hit> nearest);

  /// Returns the next questions, for different shards. All former questions must have been
  /// answered.
  std::vector<ShardQuestion> next();

  /// sides[i] is what find_sides() answers to question.rays[i] in the shard. `crossings`: those of
  /// each ray, for kParity and kWinding.
  void take(const ShardQuestion& question, std::span<const Side> sides,
            std::span<const std::uint32_t> crossings);
  /// The question has no answer: its points then have none.
  void lose(const ShardQuestion& question);

  /// After the last question: the side of each point.
  std::span<const Side> sides() const { return sides_; }
  /// After the last question: of each point's rays, those that say inside.
  std::span<const std::uint8_t> votes() const { return votes_; }

 private:
  bool by_normal() const { return question_.rule == SideRule::kNormal; }
  void begin_part();
  void end_part();
  void ask_for_side(std::uint32_t point, std::vector<ShardQuestion>& by_shard);
  void ask_for_crossings(std::uint32_t point, ShardRay& ray, std::vector<ShardQuestion>& by_shard);

  const ShardCut* cut_ = nullptr;
  SideQuestion question_;
  std::span<const accel::geometry::Ray> points_;
  std::span<const accel::geometry::Hit> nearest_;
  std::vector<Side> sides_;  // kOutside: or no answer yet
  std::vector<std::uint8_t> votes_;
  // The points that are asked for now, and the sums of their crossings, those of a point in a row.
  std::size_t first_ = 0, end_ = 0;
  std::vector<std::uint32_t> crossings_;
};

}  // namespace sightline::scenegraph::query

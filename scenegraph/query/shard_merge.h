// One batch of rays answered by the shards of a scene: which rays each shard is asked for, and the
// answers of all shards as one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/geometry/ray.h"
#include "scenegraph/query/shard_cut.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph::query {

/// Rays that a shard is asked for at a time.
struct ShardQuestion {
  std::uint32_t shard = 0;
  std::vector<std::uint32_t> rays{};  ///< Their indices in the batch, ascending.
};

/// The questions of all shards, of which the i-th is for shard i, without those that have no rays.
std::vector<ShardQuestion> with_rays(std::vector<ShardQuestion> by_shard);

/// Merges the answers of shards. After begin(), call next() until it returns nothing; each of its
/// questions is answered by take() or lose(). Closest and any ask the shards of a ray one after the
/// other, as the ray enters them; count and all ask all at once. The answers are those of trace(),
/// count_hits() and list_hits() to the whole scene, but for `work`, which is the sum over the
/// shards. Threads: one at a time.
class ShardMerge {
 public:
  /// The rays and the cut must not change until the batch is done. `max_hits`: for kAll. `points`:
  /// whether the rays are points, as in TraceOptions.
  void begin(const ShardCut& cut, QueryKind kind, std::span<const accel::geometry::Ray> rays,
             std::uint32_t max_hits, bool points = false);

  /// Returns the next questions, for different shards. All former questions must have been
  /// answered.
  std::vector<ShardQuestion> next();
  /// A ray of the batch as a question asks it: up to the nearest hit so far.
  accel::geometry::Ray limited(std::uint32_t ray) const;

  /// kClosest and kAny: hits[i] answers question.rays[i].
  void take(const ShardQuestion& question, std::span<const accel::geometry::Hit> hits);
  /// kCount and kAll: tallies[i] answers question.rays[i]. `listed`: as list_hits() gives them.
  void take(const ShardQuestion& question, std::span<const RayTally> tallies,
            std::span<const accel::geometry::Hit> listed);
  /// The question has no answer: its rays then have none, unless the kind is kAny and another shard
  /// has a hit.
  void lose(const ShardQuestion& question);

  /// kClosest and kAny, after the last question: the hit of each ray.
  std::span<const accel::geometry::Hit> hits() const { return hits_; }
  /// kCount and kAll, after the last question: the tally of each ray.
  std::span<const RayTally> tallies() const { return tallies_; }
  /// kAll, after the last question: the hits, as list_hits() gives them.
  std::span<const accel::geometry::Hit> listed() const { return listed_; }
  /// The counts of rays and of hits, without what they cost.
  const TraceStats& stats() const { return stats_; }

 private:
  /// The shards to ask for a ray: a range of order_.
  struct Way {
    std::uint32_t next = 0, end = 0;
  };
  /// The answers of one shard, for kAll.
  struct Lists {
    std::vector<std::uint32_t> rays;
    std::vector<RayTally> tallies;
    std::vector<accel::geometry::Hit> hits;
  };

  bool one_by_one() const { return kind_ == QueryKind::kClosest || kind_ == QueryKind::kAny; }
  void set_invalid(std::uint32_t ray);
  void finish();
  void merge_lists();
  void set_unanswered();

  const ShardCut* cut_ = nullptr;
  QueryKind kind_ = QueryKind::kClosest;
  std::uint32_t max_hits_ = 0;
  bool points_ = false;
  std::span<const accel::geometry::Ray> rays_;
  std::vector<std::uint8_t> order_;
  std::vector<Way> ways_;           // by ray
  std::vector<std::uint8_t> lost_;  // 1: a shard that could have changed the answer gave none
  std::vector<accel::geometry::Hit> hits_;
  std::vector<RayTally> tallies_;
  std::vector<Lists> lists_;
  std::vector<accel::geometry::Hit> listed_;
  TraceStats stats_;
  bool finished_ = false;
};

}  // namespace sightline::scenegraph::query

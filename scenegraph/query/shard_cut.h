// A scene cut into shards: ranges of its instances in Morton order, which servers answer
// separately.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "accel/geometry/aabb.h"
#include "accel/geometry/local_ray.h"
#include "accel/geometry/ray.h"
#include "accel/kdtree/tree_ray.h"
#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph::query {

/// Most shards of a scene.
inline constexpr std::uint32_t kMaxShards = 64;

/// The instances of a revision that rays can meet, ordered by the Morton codes of the centres of
/// their boxes, in ranges of about equally many triangles. A pure function of the content of the
/// revision and the number of shards: servers that have the same revision make the same cut.
/// Immutable. Threads: any.
class ShardCut {
 public:
  struct Range {
    /// The box of the instances, relative to center(); empty without any.
    accel::geometry::Aabb box;
    std::uint64_t instances = 0;
    std::uint64_t triangles = 0;  ///< Triangles of these instances.
  };

  /// `shards`: 1 to kMaxShards. Cost: one walk of the scene, and sorting its instances. Memory: 9
  /// bytes for each instance. Throws std::bad_alloc.
  ShardCut(const revision::Snapshot& snapshot, std::uint32_t shards);

  std::uint32_t size() const { return static_cast<std::uint32_t>(ranges_.size()); }
  const Range& operator[](std::uint32_t shard) const { return ranges_[shard]; }
  /// A hash of which instance is in which range, equal for equal cuts.
  std::uint64_t fingerprint() const { return fingerprint_; }
  /// The shard of an instance of the revision; size() for one that rays cannot meet.
  std::uint32_t shard_of(model::NodeId instance) const;

  /// The center of the snapshot's static tree.
  const accel::geometry::Vec3d& center() const { return center_; }
  /// A box that holds those of all ranges, and center().
  const accel::geometry::Aabb& bounds() const { return bounds_; }

 private:
  accel::geometry::Vec3d center_;
  accel::geometry::Aabb bounds_;
  std::vector<Range> ranges_;
  std::vector<model::NodeId> instances_;  // ascending
  std::vector<std::uint8_t> shards_;      // the shard of each
  std::uint64_t fingerprint_ = 0;
};

/// One of the ranges, or the whole scene.
struct Shard {
  std::shared_ptr<const ShardCut> cut{};  ///< The cut; null for the whole scene.
  std::uint32_t index = 0;

  bool has(model::NodeId instance) const {
    return cut == nullptr || cut->shard_of(instance) == index;
  }
};

/// Finds the shards that a ray may hit, or that a point may be near. It is used again for each ray.
/// It is not copied, as it refers to itself.
class ShardRay {
 public:
  /// The cut must outlive this. `points`: whether rays are points, as in TraceOptions.
  ShardRay(const ShardCut& cut, bool points) : cut_(cut), points_(points) {}
  ShardRay(const ShardRay&) = delete;
  ShardRay& operator=(const ShardRay&) = delete;

  /// Begins a ray; false if it is invalid, as for trace().
  bool begin(const accel::geometry::Ray& ray);
  /// The shards whose boxes the ray meets within its limits, by where it enters them; those within
  /// a point's limit, by distance.
  const std::vector<std::uint8_t>& by_entry();
  /// Whether the ray may hit something of the shard up to `tmax`, in its own units and included; a
  /// point may be as near.
  bool may_meet(std::uint32_t shard, double tmax) const;

 private:
  double entry(const accel::geometry::Aabb& box) const;
  double distance(const accel::geometry::Aabb& box) const;

  const ShardCut& cut_;
  const bool points_;
  accel::geometry::LocalRay local_;
  accel::kdtree::TreeRay ray_;
  bool in_bounds_ = false;
  double tmax_ = 0;
  std::vector<std::pair<double, std::uint8_t>> entries_;
  std::vector<std::uint8_t> order_;
};

}  // namespace sightline::scenegraph::query

// Takes rays through a revision, up to sixteen at a time: through the static and the dynamic trees,
// their instances, and the meshes of those.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/lazy/cell_query.h"
#include "accel/wide/float_rays.h"
#include "accel/wide/packet.h"
#include "accel/wide/transform.h"
#include "accel/wide/walk.h"
#include "scenegraph/instances/flat_scene.h"
#include "scenegraph/instances/scene_trees.h"
#include "scenegraph/query/cast_counters.h"
#include "scenegraph/query/collected.h"
#include "scenegraph/query/packet_hits.h"
#include "scenegraph/query/seen.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph::query {

/// Where a sample ray waits.
struct Arrival {
  struct Leave {
    void operator()(accel::kdtree::RefCounted* tree) const { tree->leave(); }
  };

  accel::lazy::Awaited at;
  std::unique_ptr<accel::kdtree::RefCounted, Leave> owner;  ///< Keeps the tree alive.
  accel::geometry::LocalRay ray;  ///< The sample ray, in the tree's frame.
};

/// Casts one block of rays, on one thread. The casters of a block share its pin: an outer one would
/// keep what is retired until the block ends.
class Caster {
 public:
  /// `pin` must outlive the caster, and is renewed for each packet.
  Caster(accel::kdtree::EpochPin& pin, const instances::OpenTrees& trees, QueryKind kind,
         const TraceOptions& options);
  Caster(const Caster&) = delete;
  Caster& operator=(const Caster&) = delete;

  /// Casts the rays of a packet, which must outlive their answers. Returns a bit for each that is
  /// answered. The others are cancelled; or, if the thread does not wait, suspended, because they
  /// need a large cell that other threads build: cast them again when progress() has increased.
  std::uint32_t cast(const accel::geometry::RayColumns& rays, const RayPacket& packet, bool waits);
  /// The progress of the cell that has suspended rays last.
  std::uint64_t progress() const { return progress_; }

  /// Takes one ray to the first cell of a mesh that is not built; nothing if it comes to none.
  std::optional<Arrival> first_deferred_cell(const accel::geometry::RayColumns& rays,
                                             std::size_t ray);

  /// kClosest and kAny: writes the hits of the answered rays to their rows. The first ray of the
  /// packet is a multiple of wide::kLanes.
  void write(const accel::geometry::HitColumns& hits);
  /// kCount: the number of hits of an answered ray.
  RayTally count(std::size_t lane);
  /// kAll: appends the nearest max_hits hits of an answered ray in order.
  RayTally list(std::size_t lane, std::vector<accel::geometry::Hit>& hits);

  /// The stats of all rays answered.
  TraceStats stats() const;
  /// Entries of packets into instances of the static tree.
  std::uint64_t static_entries() const { return static_entries_; }

 private:
  class InstanceTests;

  void read();
  std::uint32_t end();
  void walk_tree(const instances::OpenTree& tree, accel::lazy::LazyTree& kd, std::uint32_t lanes,
                 accel::kdtree::BuildCounters& built);
  void walk_static(const instances::OpenTree& tree, accel::kdtree::BuildCounters& built);
  void walk_flat(const instances::OpenTree& tree, std::uint32_t lanes);
  void enter(const instances::Instances& tree, const instances::Instance& instance,
             std::uint32_t index, std::uint32_t lanes, accel::kdtree::BuildCounters& built);
  /// The rays of `lanes` that have not entered the instance before, for counts and lists.
  std::uint32_t entering(std::uint32_t index, std::uint32_t lanes);
  std::uint32_t answered() const { return packet_.lanes & ~scene_.suspended; }
  std::uint32_t work(std::size_t lane) const;
  accel::geometry::HitState state(std::size_t lane) const;

  accel::kdtree::EpochPin& pin_;
  const instances::OpenTrees trees_;
  /// The static instances, as far as they are flat; null if none is.
  const std::shared_ptr<const instances::FlatScene> flat_;
  const QueryKind kind_;
  const TraceOptions options_;
  bool samples_ = false;  // see CellQuery
  CastCounters counters_;
  TraceStats stats_;
  std::uint64_t entries_ = 0, static_entries_ = 0;  // of packets into instances
  std::vector<Collected> collected_;                // by ray, for counts and lists; else empty
  std::uint64_t progress_ = 0;
  std::optional<Arrival> arrival_;
  // The current packet.
  const accel::geometry::RayColumns* rays_ = nullptr;
  RayPacket packet_;
  std::array<accel::wide::HitSink, accel::wide::kLanes> sinks_, flat_sinks_;
  accel::wide::GivenRays given_;
  accel::wide::BestHits best_;
  accel::wide::Packet scene_, mesh_;  // the rays in the frame of a tree, and of an instance
  Masks masks_;
  std::uint32_t valid_ = 0;               // rays that are not invalid
  const model::Affine* frame_ = nullptr;  // that of the instance entered last
  std::uint32_t in_frame_ = 0;            // the rays that are in range in that frame
  model::Affine world_from_local_;        // for points: of the instance entered last
  accel::lazy::CellQuery cells_;
};

}  // namespace sightline::scenegraph::query

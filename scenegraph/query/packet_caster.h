// Rays in packets on their way through a revision: the static and the dynamic trees, their
// instances, the meshes of those.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/lazy/walk_lazily.h"
#include "accel/wide/carry.h"
#include "accel/wide/float_rays.h"
#include "accel/wide/packet.h"
#include "accel/wide/walk.h"
#include "scenegraph/instances/scene_trees.h"
#include "scenegraph/query/cast_counters.h"
#include "scenegraph/query/collected.h"
#include "scenegraph/query/packet_hits.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph::query {

/// The instances that the rays of a packet entered last: an instance lies in several cells. A
/// forgotten one costs only time.
class RecentLanes {
 public:
  void clear() { entries_.fill({}); }

  /// Those of `lanes` that have not entered the instance, which they do now.
  std::uint32_t add(std::uint32_t id, std::uint32_t lanes) {
    for (Entry& entry : entries_) {
      if (entry.lanes == 0 || entry.id != id) continue;
      const std::uint32_t fresh = lanes & ~entry.lanes;
      entry.lanes |= lanes;
      return fresh;
    }
    entries_[next_++ % entries_.size()] = {id, lanes};
    return lanes;
  }

 private:
  struct Entry {
    std::uint32_t id = 0, lanes = 0;
  };
  std::array<Entry, 16> entries_;
  std::size_t next_ = 0;
};

/// For one block of rays, on one thread. The casters of a block share its pin: an outer one would
/// keep what is retired until the block ends.
class PacketCaster {
 public:
  /// `pin` outlives the caster, and is renewed for each packet.
  PacketCaster(accel::kdtree::EpochPin& pin, const instances::OpenTrees& trees, QueryKind kind,
               const TraceOptions& options);
  PacketCaster(const PacketCaster&) = delete;
  PacketCaster& operator=(const PacketCaster&) = delete;

  /// Casts a range of rays, which must outlive their answers. Returns a bit for each that is
  /// answered; the others must be cast alone: they need a cell that others build, or lie beyond the
  /// range of floats.
  std::uint32_t cast(const accel::geometry::RayColumns& rays, PacketRange range);

  /// kClosest and kAny: writes the hits of the answered rays to their rows.
  void write(const accel::geometry::HitColumns& hits);
  /// kCount: the number of hits of an answered ray.
  RayTally count(std::size_t ray);
  /// kAll: appends the nearest max_hits hits of an answered ray in order.
  RayTally list(std::size_t ray, std::vector<accel::geometry::Hit>& hits);

  /// Of all rays answered.
  TraceStats stats() const;

 private:
  class SceneSlots;

  void read();
  void read_masks();
  std::uint32_t end();
  void walk_tree(const instances::OpenTree& tree, accel::kdtree::BuildCounters& built);
  void enter(const instances::Instance& instance, std::uint32_t index, std::uint32_t lanes,
             accel::kdtree::BuildCounters& built);
  /// Those of `lanes` whose answer may still change here.
  std::uint32_t left_to_cast(std::uint32_t lanes) const;
  /// For counts and lists: those of `lanes` that have not entered the instance before.
  std::uint32_t entering(std::uint32_t index, std::uint32_t lanes);
  std::uint32_t seeing(std::uint32_t mask, std::uint32_t lanes) const;
  std::uint32_t work(std::size_t ray) const;
  accel::geometry::HitState state(std::size_t ray) const;

  accel::kdtree::EpochPin& pin_;
  const instances::OpenTrees trees_;
  const QueryKind kind_;
  const TraceOptions options_;
  CastCounters counters_;
  TraceStats stats_;
  std::vector<Collected> collected_;  // by ray, for counts and lists; else empty
  // The current packet.
  const accel::geometry::RayColumns* rays_ = nullptr;
  PacketRange range_;
  std::array<accel::mesh::HitSinks, accel::wide::kLanes> sinks_;
  accel::wide::GivenRays given_;
  accel::wide::BestHits best_;
  accel::wide::Packet scene_, mesh_;  // the rays in the frame of a tree, and of an instance
  std::array<std::uint32_t, accel::wide::kLanes> masks_;
  bool see_all_ = true;      // all bits of all masks are set
  std::uint32_t valid_ = 0;  // rays that are not invalid
  std::uint32_t alone_ = 0;  // rays that must be cast alone
  std::uint32_t saw_deferred_ = 0;
  bool renewed_ = false;                  // the pin, since the packet began
  bool leads_ = true;                     // the walk of the scene's tree goes on behind an instance
  const model::Affine* frame_ = nullptr;  // of the instance that was entered last
  std::uint32_t in_frame_ = 0;            // the rays that are in range there
  accel::lazy::LazyQuery lazy_;
};

}  // namespace sightline::scenegraph::query

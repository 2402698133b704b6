// One ray through the scene: its two trees, instances near to far, each in its own frame.
#pragma once

#include <optional>
#include <vector>

#include "accel/mesh/mesh_tree.h"
#include "scenegraph/instances/scene_trees.h"
#include "scenegraph/query/entered.h"
#include "scenegraph/trace.h"

namespace sightline::scenegraph {

/// For one block of rays, on one thread that is pinned to an epoch.
class RayCaster {
 public:
  RayCaster(const TwoTrees& trees, const TraceOptions& options);
  RayCaster(const RayCaster&) = delete;
  RayCaster& operator=(const RayCaster&) = delete;

  /// Sets the nearest hit or, for kAny, whether there is one. With AtBusy::kLeave false, if the ray
  /// met a large cell that other threads are building: ask again when `progress` has grown.
  bool cast(const accel::Ray& ray, accel::AtBusy at_busy, accel::Hit& hit);
  /// How many hits there are; or nothing, likewise.
  std::optional<RayTally> count(const accel::Ray& ray, accel::AtBusy at_busy);
  /// Of the cell that the last ray was put aside for.
  std::uint64_t progress() const { return progress_; }
  /// Adds the nearest max_hits hits to `hits`, in order.
  RayTally list(const accel::Ray& ray, std::vector<accel::Hit>& hits);

  TraceStats stats() const;

 private:
  struct Visit;
  /// One of the two trees, and the ray as it stands in it.
  struct Entry {
    const Instances* instances = nullptr;
    const Departed* departed = nullptr;  ///< Null: nothing has.
    std::uint32_t first = 0;             ///< What its instances' places count from.
    accel::LocalRay centered;
    accel::TreeRay ray;
    accel::BuildCounters* built = nullptr;
  };

  enum class Search { kDone, kInvalid, kPutAside };

  Search search(const accel::Ray& ray, accel::MeshQuery& query);
  void walk_trees(const accel::Ray& ray, accel::MeshQuery& query);
  static bool enter_tree(const accel::Ray& ray, Entry& entry);
  void walk_tree(const accel::Ray& ray, const Entry& entry, accel::MeshQuery& query);
  std::uint32_t work_of(const accel::MeshQuery& query) const;
  void enter_instance(const accel::Ray& ray, const Instance& instance, std::uint32_t place,
                      accel::BuildCounters& built, accel::MeshQuery& query);

  const TwoTrees trees_;
  TraceOptions options_;
  accel::AtUnbuilt at_unbuilt_;
  accel::Distinct<accel::ListedHit> list_;
  accel::Distinct<std::uint32_t> primitives_;  // hit in the instance that the ray is in
  EnteredOnce entered_;
  std::vector<accel::BoxRef> waiting_;  // while a list is searched: references not looked at yet
  const Affine* frame_ = nullptr;       // of the instance that the ray entered last
  bool in_frame_ = false;               // the query's ray stands there; else it has no place there
  std::uint64_t counted_ = 0;           // hits of the ray in the instances that it has left
  std::uint64_t work_before_ = 0;
  std::uint64_t progress_ = 0;
  TraceStats stats_;
  accel::WalkCounters walked_;
  accel::BuildCounters built_, built_moving_;
  Entry still_, moving_;
};

}  // namespace sightline::scenegraph

// Casts one ray: the static and the dynamic tree, instances near to far, each in its own frame.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "accel/mesh/mesh_tree.h"
#include "scenegraph/instances/scene_trees.h"
#include "scenegraph/query/entered.h"
#include "scenegraph/query/trace_options.h"
#include "scenegraph/query/trace_stats.h"

namespace sightline::scenegraph::query {

/// For one block of rays, on one thread that is pinned to an epoch.
class RayCaster {
 public:
  RayCaster(const instances::OpenTrees& trees, const TraceOptions& options);
  RayCaster(const RayCaster&) = delete;
  RayCaster& operator=(const RayCaster&) = delete;

  /// Sets the nearest hit or, for kAny, whether there is one. With WhenPending::kReturn: false if
  /// the ray met a large cell that other threads are building; ask again when progress() has
  /// increased.
  bool cast(const accel::geometry::Ray& ray, accel::lazy::WhenPending when_pending,
            accel::geometry::Hit& hit);
  /// The number of hits; nothing if suspended, as cast().
  std::optional<RayTally> count(const accel::geometry::Ray& ray,
                                accel::lazy::WhenPending when_pending);
  /// Of the cell that suspended the last ray.
  std::uint64_t progress() const { return progress_; }
  /// Adds the nearest max_hits hits to `hits`, in order.
  RayTally list(const accel::geometry::Ray& ray, std::vector<accel::geometry::Hit>& hits);

  TraceStats stats() const;

 private:
  struct Visit;
  /// One of the two trees, and the ray in its coordinates.
  struct Entry {
    const instances::Instances* instances = nullptr;
    const instances::RemovedFilter* removed = nullptr;  ///< Null: nothing has.
    std::uint32_t first = 0;                            ///< The index of its first instance.
    accel::geometry::LocalRay centered;
    accel::kdtree::TreeRay ray;
    accel::kdtree::BuildCounters* built = nullptr;
  };

  enum class Search { kDone, kInvalid, kSuspended };

  Search search(const accel::geometry::Ray& ray, accel::mesh::MeshQuery& query);
  void walk_trees(const accel::geometry::Ray& ray, accel::mesh::MeshQuery& query);
  std::array<const Entry*, 2> trees_by_entry(const accel::geometry::Ray& ray);
  static bool enter_tree(const accel::geometry::Ray& ray, Entry& entry);
  void walk_instances(const accel::geometry::Ray& ray, const Entry& entry,
                      accel::mesh::MeshQuery& query);
  std::uint32_t work_of(const accel::mesh::MeshQuery& query) const;
  void enter_instance(const accel::geometry::Ray& ray, const instances::Instance& instance,
                      std::uint32_t index, accel::kdtree::BuildCounters& built,
                      accel::mesh::MeshQuery& query);

  const instances::OpenTrees trees_;
  TraceOptions options_;
  accel::mesh::OnDeferred on_deferred_;
  accel::mesh::UniqueHits<accel::mesh::ListedHit> list_;
  accel::mesh::UniqueHits<std::uint32_t> primitives_;  // hit in the instance that the ray is in
  EnteredOnce entered_;
  std::vector<accel::kdtree::Reference> pending_;  // references of a searched list not yet visited
  const model::Affine* frame_ = nullptr;           // of the instance that the ray entered last
  bool in_frame_ = false;                          // the query's ray is valid in that frame
  std::uint64_t counted_ = 0;                      // hits of the ray in earlier instances
  std::uint64_t work_before_ = 0;
  std::uint64_t progress_ = 0;
  TraceStats stats_;
  accel::kdtree::WalkCounters walked_;
  accel::kdtree::BuildCounters built_, built_dynamic_;
  Entry static_entry_, dynamic_entry_;
};

}  // namespace sightline::scenegraph::query

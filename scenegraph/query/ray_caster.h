// One ray at a time on its way through a revision: the static and the dynamic trees, their
// instances, the meshes of those. scenegraph/trace.cpp takes the steps in order.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/lazy/walk_lazily.h"
#include "accel/mesh/mesh_tree.h"
#include "scenegraph/instances/scene_trees.h"
#include "scenegraph/query/cast_counters.h"
#include "scenegraph/query/collected.h"
#include "scenegraph/query/entered.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph::query {

/// One of the trees, and the current ray in its coordinates.
struct TreeEntry {
  const instances::Instances* instances = nullptr;
  const instances::RemovedFilter* removed = nullptr;  ///< Null: none.
  std::uint32_t first = 0;                            ///< The index of its first instance.
  /// What rays built in this tree and in the meshes that they entered through it is added here.
  accel::kdtree::BuildCounters* built = nullptr;
  accel::geometry::LocalRay centered;
  accel::kdtree::TreeRay ray;
  double entered_at = 0;  ///< Where the ray enters the tree's bounds.
};

/// For one block of rays, on one thread.
///
/// For each ray: begin(), then the steps trees_by_entry(), walk_instances(), enter_frame() and
/// ask_mesh(), then end(), and if that is true one answer.
class RayCaster {
 public:
  /// `pin` outlives the caster, and is renewed for each ray: nothing that a ray read is used again.
  RayCaster(accel::kdtree::EpochPin& pin, const instances::OpenTrees& trees,
            const TraceOptions& options);
  RayCaster(const RayCaster&) = delete;
  RayCaster& operator=(const RayCaster&) = delete;

  /// All rays stop at the first cell of a mesh that is not built, and it is reported.
  void wait_at_cells(accel::lazy::WaitingRays& waiting) { waiting_ = &waiting; }
  /// The current ray in the frame that it has entered.
  const accel::geometry::LocalRay& local_ray() const { return query_.ray; }

  /// Begins a ray, which must outlive its answer.
  void begin(QueryKind kind, const accel::geometry::Ray& ray,
             accel::lazy::WhenPending when_pending);

  /// The trees whose bounds the ray meets, by where it enters them: hits in one bound the walks of
  /// the next. None for an invalid ray.
  std::span<TreeEntry* const> trees_by_entry();

  /// Walks the tree, and expands cells on the way as TraceOptions::growth allows. Calls
  /// enter(const Instance&) for the instances that the ray may meet, near to far.
  template <class Enter>
  void walk_instances(TreeEntry& tree, const Enter& enter);

  /// Carries the ray into the instance's frame. False: it is out of the hit rule's range there.
  bool enter_frame(const instances::Instance& instance);

  /// Asks the tree of the instance's mesh for hits, after enter_frame().
  void ask_mesh(const instances::Instance& instance, TreeEntry& tree);

  /// Nothing can change the answer any more, or the ray is suspended or cancelled.
  bool is_done() const { return query_.is_done(); }

  /// False: the ray has no answer. It is cancelled, or suspended because it met a large cell that
  /// other threads are building; that only with WhenPending::kReturn. Then begin it again when
  /// progress() has increased.
  bool end();
  /// Of the cell that suspended the last ray.
  std::uint64_t progress() const { return query_.progress; }

  /// kClosest, and kAny without the surface: the hit, a miss, or an invalid ray.
  accel::geometry::Hit hit() const;
  /// kCount: the number of hits.
  RayTally count();
  /// kAll: appends the nearest max_hits hits in order.
  RayTally list(std::vector<accel::geometry::Hit>& hits);

  /// Of all rays so far.
  TraceStats stats() const;

 private:
  template <class Enter>
  class InstanceTest;

  bool enter_bounds(TreeEntry& tree) const;
  bool is_seen(const TreeEntry& tree, std::uint32_t id) const;
  accel::geometry::Hit hit_of(const accel::mesh::ListedHit& listed) const;
  RayTally tally() const;
  std::uint32_t work() const;

  accel::kdtree::EpochPin& pin_;
  const instances::OpenTrees trees_;
  TraceOptions options_;
  accel::lazy::WaitingRays* waiting_ = nullptr;
  std::vector<TreeEntry> entries_;  // the static tree first
  TraceStats stats_;
  CastCounters counters_;
  // Memory that is used again for each ray.
  Collected collected_;
  // The current ray.
  const accel::geometry::Ray* ray_ = nullptr;
  bool valid_ = false;
  accel::mesh::MeshQuery query_;
  std::vector<TreeEntry*> by_entry_;      // those whose bounds it meets
  const model::Affine* frame_ = nullptr;  // of the instance that the ray entered last
  bool in_frame_ = false;                 // the query's ray is valid in that frame
  std::uint64_t work_before_ = 0;
};

/// What a walk of one of the trees tests: instances, and the groups that hold them.
template <class Enter>
class RayCaster::InstanceTest {
 public:
  InstanceTest(RayCaster& caster, const TreeEntry& tree, const Enter& enter)
      : caster_(caster), tree_(tree), enter_(enter) {}

  double limit() const { return caster_.query_.best_t / tree_.centered.unit + tree_.ray.slack; }

  bool leaf(std::span<const std::uint32_t> ids) {
    return std::any_of(ids.begin(), ids.end(), [&](std::uint32_t id) { return instance(id); });
  }

  /// The scene's trees have only leaves.
  static bool finished(const accel::kdtree::FinishedSubtree&) { return false; }

  bool references(std::span<const accel::kdtree::Reference> refs) {
    return std::any_of(refs.begin(), refs.end(),
                       [&](const accel::kdtree::Reference& ref) { return reference(ref); });
  }

  /// Opens groups whose boxes the ray may meet.
  bool reference(const accel::kdtree::Reference& ref) {
    ++tests;
    if (!accel::kdtree::may_meet(tree_.ray, ref.bounds(), limit())) return false;
    if (!ref.openable()) return instance(ref.id);
    if (caster_.query_.is_cancelled()) return true;
    const auto cluster = tree_.instances->members_of_cluster(ref);
    if (!cluster.empty()) return references(cluster);
    if (caster_.query_.on_deferred == accel::lazy::OnDeferred::kSkip &&
        !tree_.instances->is_open(ref)) {
      caster_.query_.saw_deferred = true;
      return false;
    }
    std::vector<accel::kdtree::Reference> members;
    tree_.instances->open(ref, members);
    return references(members);
  }

  bool everything() { return references(tree_.instances->coarsest()); }

  std::uint64_t tests = 0;  ///< Of members of references.

 private:
  /// Whether an instance is entered depends only on the ray and the instance's box, not on the cell
  /// that holds it.
  bool instance(std::uint32_t id) {
    const instances::Instance& instance = (*tree_.instances)[id];
    if ((instance.mask & caster_.ray_->mask) == 0 || recent_.contains_or_add(id)) return false;
    if (!accel::kdtree::may_meet(tree_.ray, instance.box, limit())) return false;
    if (!caster_.is_seen(tree_, id)) return false;
    if (caster_.query_.collects() && !caster_.collected_.enter(tree_.first + id)) return false;
    enter_(instance);
    return caster_.is_done();
  }

  RayCaster& caster_;
  const TreeEntry& tree_;
  const Enter& enter_;
  RecentlyEntered recent_;
};

template <class Enter>
void RayCaster::walk_instances(TreeEntry& tree, const Enter& enter) {
  InstanceTest<Enter> test(*this, tree, enter);
  if (tree.instances->is_searched()) {
    test.everything();
    counters_.walked.steps += test.tests;
    return tree.instances->count_searched(test.tests);
  }
  walk_lazily(tree.instances->tree(), tree.ray, query_, counters_.walked, *tree.built, test);
}

}  // namespace sightline::scenegraph::query

// Tests the instances of one of the scene's trees against the rays of a packet: in leaves, and in
// the lists of cells that are not built.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "accel/lazy/growing_leaf.h"
#include "accel/wide/float_rays.h"
#include "accel/wide/lane_ray.h"
#include "scenegraph/query/caster.h"
#include "scenegraph/query/entered.h"
#include "scenegraph/query/seen.h"

namespace sightline::scenegraph::query {

/// The Content of accel::lazy::GrowingLeaf in a scene's tree. It is made for one packet and one
/// tree.
class Caster::InstanceTests {
 public:
  InstanceTests(Caster& caster, const instances::OpenTree& tree, const accel::wide::Frame& frame,
                accel::kdtree::BuildCounters& built)
      : caster_(caster),
        packet_(caster.scene_),
        tree_(tree.instances),
        open_(tree),
        first_(static_cast<std::uint32_t>(tree.first)),
        frame_(frame),
        built_(built) {}

  /// Visits the instance of a tree that has only one: its box need not be tested, as its mesh's
  /// will be.
  void visit_only(std::uint32_t id, std::uint32_t lanes) {
    const instances::Instance& instance = tree_[id];
    lanes = caster_.masks_.seeing(instance.mask, lanes);
    if (lanes != 0 && is_seen(open_, id, caster_.options_.selection))
      caster_.enter(tree_, instance, first_ + id, lanes, built_);
  }

  /// Whether an instance is entered depends only on the ray and the instance's box, not on the cell
  /// that holds it.
  void leaf(std::span<const std::uint32_t> ids, std::uint32_t lanes) {
    for (const std::uint32_t id : ids) {
      lanes = packet_.left(lanes);
      if (lanes == 0) return;
      const instances::Instance& instance = tree_[id];
      std::uint32_t entering = caster_.masks_.seeing(instance.mask, recent_.add(id, lanes));
      if (entering != 0) entering = meeting(instance.box, entering);
      if (entering == 0 || !is_seen(open_, id, caster_.options_.selection)) continue;
      if (!caster_.collected_.empty()) entering = caster_.entering(first_ + id, entering);
      caster_.enter(tree_, instance, first_ + id, entering, built_);
      tighten(first_ + id, entering);
    }
  }

  void references(std::span<const accel::kdtree::Reference> refs, std::uint32_t lanes) {
    for (const accel::kdtree::Reference& ref : refs) {
      ++tests_;
      if (caster_.cells_.is_cancelled()) packet_.stopped = true;
      lanes = packet_.left(lanes);
      if (lanes == 0) return;
      const std::uint32_t met = meeting(ref.bounds(), lanes);
      if (met != 0) visit(ref, met);
    }
  }

  /// Counts the members tested as spent on the root.
  void everything(const accel::kdtree::DeferredCell& root, std::uint32_t lanes) {
    const std::uint64_t before = tests_;
    references(tree_.coarsest(), lanes);
    caster_.counters_.walked.steps += tests_ - before;
    root.spent.fetch_add(tests_ - before, std::memory_order_relaxed);
  }

 private:
  /// Visits a reference with rays that may meet its box. Opens groups.
  void visit(const accel::kdtree::Reference& ref, std::uint32_t lanes) {
    if (!ref.openable()) return leaf(std::span(&ref.id, 1), lanes);
    const auto cluster = tree_.members_of_cluster(ref);
    if (!cluster.empty()) return references(cluster, lanes);
    if (caster_.cells_.growth == Growth::kBuiltOnly && !tree_.is_open(ref)) {
      packet_.saw_deferred |= lanes;
      return;
    }
    std::vector<accel::kdtree::Reference> members;
    tree_.open(ref, members);
    references(members, lanes);
  }

  /// Lowers the limits of these rays, which have entered an instance.
  void tighten(std::uint32_t index, std::uint32_t lanes) {
    const accel::wide::BestHits& best = caster_.best_;
    if (packet_.goal == accel::wide::Goal::kAny || packet_.stopped ||
        caster_.kind_ == QueryKind::kCount)
      return;
    for (lanes &= best.found; lanes != 0; lanes &= lanes - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
      const bool here = caster_.kind_ == QueryKind::kAll || best.instance[lane] == index;
      // A list that is not full has no limit.
      if (here && best.t[lane] < std::numeric_limits<double>::max())
        accel::wide::tighten(packet_, lane);
    }
  }

  /// The rays of `lanes` that may meet a box before their best hits.
  std::uint32_t meeting(const accel::geometry::Aabb& box, std::uint32_t lanes) const {
    return accel::wide::meeting(packet_, in_frame(frame_, box), lanes);
  }

  Caster& caster_;
  accel::wide::Packet& packet_;
  const instances::Instances& tree_;
  const instances::OpenTree& open_;
  const std::uint32_t first_;
  const accel::wide::Frame& frame_;  // of the tree that the rays are prepared for
  accel::kdtree::BuildCounters& built_;
  RecentLanes recent_;
  std::uint64_t tests_ = 0;  // references tested
};

}  // namespace sightline::scenegraph::query

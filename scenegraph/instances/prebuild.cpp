// Walks down one tree at the leaf centres of the other.
#include "scenegraph/instances/prebuild.h"

#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/lazy/lazy_tree.h"

namespace sightline::scenegraph::instances {
namespace {

using accel::geometry::Aabb;
using accel::kdtree::Slot;

/// Leaves visited under one epoch pin.
constexpr std::size_t kLeavesPerPin = 256;

struct Cell {
  Slot slot;
  Aabb box;
};

/// The middles of the non-empty leaves, in scene coordinates.
std::vector<accel::geometry::Vec3d> built_points(const Instances& grown) {
  const accel::kdtree::EpochPin pin;
  const accel::kdtree::KdTree& tree = grown.tree().tree();
  std::vector<accel::geometry::Vec3d> points;
  std::vector<Cell> waiting{{accel::kdtree::load(tree.root()), tree.bounds()}};
  while (!waiting.empty()) {
    const auto [slot, box] = waiting.back();
    waiting.pop_back();
    if (slot.is_binary()) {
      const accel::geometry::HalvedCell halves =
          accel::geometry::halve(box, slot.axis(), slot.position());
      waiting.push_back({accel::kdtree::load(tree.children(slot)[0]), halves.left});
      waiting.push_back({accel::kdtree::load(tree.children(slot)[1]), halves.right});
    } else if (!slot.is_deferred() && slot.leaf_count() > 0) {
      points.push_back((accel::geometry::Vec3d(box.lo) + accel::geometry::Vec3d(box.hi)) * 0.5 +
                       grown.center());
    }
  }
  return points;
}

void grow_at(accel::lazy::LazyTree& tree, const accel::geometry::Vec3d& point) {
  accel::kdtree::BuildCounters built;
  for (accel::kdtree::AtomicSlot* at = &tree.root();;) {
    const Slot slot = accel::kdtree::load(*at);
    if (slot.is_deferred()) {
      if (tree.expand(*at, accel::lazy::WhenPending::kWait, built) ==
          accel::lazy::ExpandResult::kRetry)
        continue;
      return;
    }
    if (!slot.is_binary()) return;
    const bool right =
        point[static_cast<std::size_t>(slot.axis())] >= static_cast<double>(slot.position());
    at = &tree.tree().children(slot)[right ? 1u : 0u];
  }
}

}  // namespace

void prebuild_like(const Instances& grown, const Instances& fresh) {
  const std::vector<accel::geometry::Vec3d> points = built_points(grown);
  for (std::size_t first = 0; first < points.size(); first += kLeavesPerPin) {
    const accel::kdtree::EpochPin pin;
    for (std::size_t i = first; i < std::min(first + kLeavesPerPin, points.size()); ++i)
      grow_at(fresh.tree(), points[i] - fresh.center());
  }
}

}  // namespace sightline::scenegraph::instances

// Walks down one tree at the leaf centres of the other.
#include "scenegraph/instances/prebuild.h"

#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/lazy/lazy_tree.h"

namespace sightline::scenegraph::instances {
namespace {

using accel::geometry::Aabb;
using accel::kdtree::Slot;
using accel::kdtree::WideNode;

/// Leaves visited under one epoch pin.
constexpr std::size_t kLeavesPerPin = 256;

/// Calls visit(box) for the leaves at and below a slot; boxes are in the tree's frame.
template <class Visit>
void each_leaf(Slot slot, const Aabb& box, const Visit& visit) {
  if (!slot || slot.is_deferred() || slot == Slot::empty_list()) return;
  if (slot.is_finished()) slot = slot.finished()->root();
  if (!slot.is_node()) return visit(box);
  for (std::size_t i = 0; i < accel::kdtree::kWidth; ++i)
    each_leaf(slot.node()->child(i), slot.node()->box(i), visit);
}

/// The center of the tree's frame, in scene coordinates.
accel::geometry::Vec3d center_of(const Instances& instances) {
  return accel::geometry::Vec3d(instances.tree().frame().center) + instances.center();
}

/// The middles of the leaves, in scene coordinates.
std::vector<accel::geometry::Vec3d> built_points(const Instances& grown) {
  const accel::kdtree::EpochPin pin;
  const accel::lazy::LazyTree& tree = grown.tree();
  std::vector<accel::geometry::Vec3d> points;
  const accel::geometry::Vec3d center = center_of(grown);
  const double half = 0.5 / static_cast<double>(tree.frame().scale);
  each_leaf(accel::kdtree::load(tree.tree().root()), tree.frame().bounds, [&](const Aabb& box) {
    points.push_back((accel::geometry::Vec3d(box.lo) + accel::geometry::Vec3d(box.hi)) * half +
                     center);
  });
  return points;
}

bool holds(const Aabb& box, const accel::geometry::Vec3d& point) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (point[a] < static_cast<double>(box.lo[a]) || point[a] > static_cast<double>(box.hi[a]))
      return false;
  }
  return true;
}

/// The child whose box holds a point; null if none does.
accel::kdtree::AtomicSlot* child_at(const WideNode& node, const accel::geometry::Vec3d& point) {
  for (std::size_t i = 0; i < accel::kdtree::kWidth; ++i) {
    if (node.child(i) && holds(node.box(i), point)) return &node.slot(i);
  }
  return nullptr;
}

/// Expands the cells that hold a point of the tree's frame.
void grow_at(accel::lazy::LazyTree& tree, const accel::geometry::Vec3d& point) {
  accel::kdtree::BuildCounters built;
  for (accel::kdtree::AtomicSlot* at = &tree.root(); at != nullptr;) {
    const Slot slot = accel::kdtree::load(*at);
    if (slot.is_deferred()) {
      if (tree.expand(*at, built) != accel::lazy::AtCell::kAdvance) return;
    } else {
      at = slot.is_node() ? child_at(*slot.node(), point) : nullptr;
    }
  }
}

}  // namespace

void prebuild_like(const Instances& grown, const Instances& fresh) {
  const std::vector<accel::geometry::Vec3d> points = built_points(grown);
  const accel::geometry::Vec3d center = center_of(fresh);
  const auto scale = static_cast<double>(fresh.tree().frame().scale);
  for (std::size_t first = 0; first < points.size(); first += kLeavesPerPin) {
    const accel::kdtree::EpochPin pin;
    for (std::size_t i = first; i < std::min(first + kLeavesPerPin, points.size()); ++i)
      grow_at(fresh.tree(), (points[i] - center) * scale);
  }
}

}  // namespace sightline::scenegraph::instances

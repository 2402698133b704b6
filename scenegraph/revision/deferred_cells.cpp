// The cells of a scene that rays have not built yet, for pictures of them.
#include "scenegraph/revision/deferred_cells.h"

#include <algorithm>

#include "accel/kdtree/deferred_boxes.h"
#include "accel/kdtree/epoch.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/mesh/mesh_tree.h"
#include "scenegraph/model/double_box.h"

namespace sightline::scenegraph::revision {
namespace {

using accel::geometry::Aabb;
using model::DoubleBox;

/// Keeps the largest boxes.
class Largest {
 public:
  explicit Largest(std::size_t limit) : limit_(limit) {}

  void add(const DoubleBox& box) {
    ++cells_.total;
    if (limit_ == 0 || box.empty()) return;
    const accel::geometry::Vec3d d = box.hi - box.lo;
    const double half_area = d.x * d.y + d.y * d.z + d.z * d.x;
    if (boxes_.size() == limit_) {
      if (half_area <= boxes_.front().half_area) return;
      std::ranges::pop_heap(boxes_, kSmallestFirst);
      boxes_.pop_back();
    }
    boxes_.push_back({half_area, box});
    std::ranges::push_heap(boxes_, kSmallestFirst);
  }

  DeferredCells finish() && {
    std::ranges::sort_heap(boxes_, kSmallestFirst);
    cells_.boxes.reserve(boxes_.size());
    for (const auto& [half_area, box] : boxes_) {
      const auto& [lo, hi] = box;
      cells_.boxes.push_back({static_cast<float>(lo.x), static_cast<float>(lo.y),
                              static_cast<float>(lo.z), static_cast<float>(hi.x),
                              static_cast<float>(hi.y), static_cast<float>(hi.z)});
    }
    return std::move(cells_);
  }

 private:
  struct Sized {
    double half_area = 0;
    DoubleBox box;
  };
  static constexpr auto kSmallestFirst = [](const Sized& a, const Sized& b) {
    return a.half_area > b.half_area;
  };

  const std::size_t limit_;
  std::vector<Sized> boxes_;  // a heap
  DeferredCells cells_;
};

void add_scene_tree(const instances::SceneTree& tree, Largest& largest) {
  const instances::Instances* opened = tree.instances_so_far();
  if (opened == nullptr || !opened->begun() || opened->size() == 0) return;
  const accel::geometry::Vec3d center = opened->center();
  accel::kdtree::for_each_deferred_box(opened->tree().tree(), [&](const Aabb& box) {
    DoubleBox world(box);
    world.lo = world.lo + center;
    world.hi = world.hi + center;
    largest.add(world);
  });
}

void add_mesh(const model::Mesh& mesh, const model::Affine& world_from_local, bool entered,
              Largest& largest) {
  const bool resident = mesh.is_resident();
  const accel::kdtree::KdTree* tree = resident ? mesh.tree().kd() : nullptr;
  if (!entered || tree == nullptr) {
    if (!resident || mesh.tree().untouched())
      largest.add(mapped(world_from_local, DoubleBox(mesh.bounds())));
    return;
  }
  accel::kdtree::for_each_deferred_box(
      *tree, [&](const Aabb& box) { largest.add(mapped(world_from_local, DoubleBox(box))); });
}

}  // namespace

DeferredCells deferred_cells(const Snapshot& snapshot, std::size_t limit) {
  Largest largest(limit);
  const accel::kdtree::EpochPin pin;
  for (const instances::Level& level : snapshot.shared_trees().levels)
    add_scene_tree(*level.tree, largest);
  hierarchy::for_each_reached(
      snapshot.hierarchy(),
      [&](const model::Node& node, const model::Affine& world, const model::Affine&) {
        add_mesh(*node.mesh, world, node.entered->load(std::memory_order_relaxed), largest);
      });
  return std::move(largest).finish();
}

}  // namespace sightline::scenegraph::revision
